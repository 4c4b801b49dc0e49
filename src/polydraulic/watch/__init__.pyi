from .diagnosis import Suspect
from .expected import Expected
from .watch import Alarm, FaultWatch, Outlook
from .watched import Watched

__all__ = ["Alarm", "Expected", "FaultWatch", "Outlook", "Suspect", "Watched"]

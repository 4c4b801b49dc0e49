from .diagnosis import Suspect
from .expected import Expected
from .naming import FaultNetworks, Opinion
from .watch import Alarm, FaultWatch, Outlook
from .watched import Watched

__all__ = ["Alarm", "Expected", "FaultNetworks", "FaultWatch", "Opinion", "Outlook", "Suspect", "Watched"]

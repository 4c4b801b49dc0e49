"""Who may talk to the cockpit: a browser on this computer that was given the token, on a page of the cockpit's own.

Other sites that the same browser shows can send requests to this computer, too, under a name of theirs (rebinding) or from a script. So the
name must be this computer's, the origin the cockpit's own, and the cookie the one that the token was exchanged for.
"""

import hmac
import secrets
from dataclasses import dataclass, field

_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True)
class Guard:
    """What requests are compared with.

    Attributes
    ----------
    port : int
        Cookies ignore ports: that of another cockpit must have another name.
    token : str
        In the URL that is printed.
    """

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)
    _secret: str = field(default_factory=lambda: secrets.token_urlsafe(24), repr=False)

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    @property
    def cookie(self) -> tuple[str, str]:
        """Name and value of the cookie."""
        return f"polydraulic_cockpit_{self.port}", self._secret

    @property
    def headers(self) -> dict[str, str]:
        """What every answer says to the browser."""
        return dict(_HEADERS)

    def is_host(self, host: str | None) -> bool:
        """Whether a request was sent to this computer by its own name."""
        return host in {f"{name}:{self.port}" for name in ("127.0.0.1", "localhost")}

    def is_origin(self, origin: str | None) -> bool:
        """Whether a script's page is the cockpit's own."""
        return origin in {f"http://{name}:{self.port}" for name in ("127.0.0.1", "localhost")}

    def is_token(self, given: str | None) -> bool:
        """Whether this is the token of the URL."""
        return given is not None and hmac.compare_digest(given.encode(), self.token.encode())

    def is_cookie(self, given: str | None) -> bool:
        """Whether this is the cookie's value."""
        return given is not None and hmac.compare_digest(given.encode(), self._secret.encode())

"""Which requests the server answers: those of its own page, for its own address.

Other sites that the browser shows can send requests to a local server too. A wrong `Host` reveals a name that was bound
to this machine to read its answers, a foreign `Origin` a request from the script of another page.
"""

from __future__ import annotations

from collections.abc import Mapping
from email.message import Message
from http import HTTPStatus

LARGEST = 65_536
"""Most bytes of the body of a request."""

NAMES = ("127.0.0.1", "localhost")
"""Names of this machine in the address of the page."""

POLICY = "default-src 'none'; frame-ancestors 'none'"
"""The content security policy of all answers but the page."""

HEADERS: Mapping[str, str] = {
    "Cache-Control": "no-store", "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer", "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin", "X-Frame-Options": "DENY",
}  # fmt: skip
"""Headers of every answer, besides the policy."""


class Refused(Exception):  # noqa: N818  # an outcome, not an error
    """A request that is refused, with its HTTP status and a text."""

    def __init__(self, status: HTTPStatus, text: str) -> None:
        super().__init__(text)
        self.status, self.text = status, text


def refuse_strangers(headers: Message, port: int) -> None:
    """Refuse a request that is not for this server, or comes from another page."""
    hosts = headers.get_all("Host", [])
    if len(hosts) != 1 or hosts[0].lower() not in [f"{name}:{port}" for name in NAMES]:
        raise Refused(HTTPStatus.FORBIDDEN, f"use the address http://127.0.0.1:{port}/")
    if any(origin.lower() != f"http://{hosts[0].lower()}" for origin in headers.get_all("Origin", [])):
        raise Refused(HTTPStatus.FORBIDDEN, "requests from other pages are refused")
    foreign = headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
    if foreign and headers.get("Sec-Fetch-Mode") != "navigate":  # a link to the page is no request of a script
        raise Refused(HTTPStatus.FORBIDDEN, "requests from other pages are refused")


def body_length(headers: Message) -> int:
    """Return the length of the body of a request in bytes; refuse other types, and large or unknown lengths."""
    if headers.get_content_type() != "application/json":
        raise Refused(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "expected the type application/json")
    lengths = headers.get_all("Content-Length", [])
    if len(lengths) != 1 or not (lengths[0].isascii() and lengths[0].isdigit()) or "Transfer-Encoding" in headers:
        raise Refused(HTTPStatus.LENGTH_REQUIRED, "expected a Content-Length")
    if len(lengths[0]) > len(str(LARGEST)) or int(lengths[0]) > LARGEST:
        raise Refused(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"expected at most {LARGEST} bytes")
    return int(lengths[0])

"""The server of the live view: the page, its data, changes of the file as they occur, positions at inputs.

It listens on this machine only and answers six requests: GET / (the page), GET /data (the motion), GET /inputs (its
sliders), GET /events (server-sent events: number of the motion, errors), POST /solve and POST /set (see `HandMotion`).

It answers requests of its own page only, for its own address: other sites that the browser shows can send requests to a
local server too. A wrong `Host` reveals a name that was bound to this machine to read its answers, a foreign `Origin` a
request from the script of another page.
"""

from __future__ import annotations

import json
import os
import re
import secrets
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from email.message import Message
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from socketserver import TCPServer
from threading import Thread
from typing import Any

from gimcli.errors import UsageError, reason
from gimcli.output.json import json_text
from gimcli.output.page.document import page
from gimcli.progress import Notify, Phases, no_phases
from gimcli.view.hand import HandMotion, Outdated
from gimcli.view.live_model import LiveModel

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
    foreign = headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin")
    foreign &= headers.get("Sec-Fetch-Mode") != "navigate"  # a link to the page is no request of a script
    if foreign or any(one.lower() != f"http://{hosts[0].lower()}" for one in headers.get_all("Origin", [])):
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


ADDRESS = "127.0.0.1"
USUAL_PORT = 8642

IDLE = 60.0
"""Seconds after which a connection without a request is closed."""

BEAT = 10.0
"""Seconds between two lines on a connection without events: a page that was closed is noticed."""

RETRY = 500
"""Milliseconds after which the page connects again."""

JSON, TEXT = "application/json; charset=utf-8", "text/plain; charset=utf-8"


class ViewServer(ThreadingHTTPServer):
    """The server of a live model."""

    daemon_threads = True
    block_on_close = False
    allow_reuse_address = os.name == "posix"  # elsewhere, two servers could then use one port

    def __init__(self, model: LiveModel, port: int = 0) -> None:
        """Listen on a port, 0: any free one. Raises OSError if it is in use."""
        self.model, self.hand, self.run = model, HandMotion(model), secrets.token_hex(4)
        script = files("gimcli.view").joinpath("live.js").read_text(encoding="utf-8")
        text = page(None, scripts=[script], connect=True)
        own = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
        assert own is not None
        self.page, self.policy = text.encode(), f"{own[1]}; frame-ancestors 'none'"
        super().__init__((ADDRESS, port), ViewRequest)

    def server_bind(self) -> None:
        """Bind the address, without asking for the name of this machine, which can take seconds."""
        TCPServer.server_bind(self)
        self.server_name, self.server_port = ADDRESS, int(self.server_address[1])

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{ADDRESS}:{self.server_port}/"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore connections that are closed or that time out."""
        import sys

        if not isinstance(sys.exception(), OSError):
            super().handle_error(request, client_address)


class ViewRequest(BaseHTTPRequestHandler):
    """One connection of the page."""

    server: ViewServer
    protocol_version = "HTTP/1.1"
    server_version, sys_version = "gim", ""
    timeout = IDLE
    disable_nagle_algorithm = True
    wbufsize = -1  # an answer is one packet

    def answer(self) -> None:
        """Answer with the page, its data, its events or a position."""
        try:
            refuse_strangers(self.headers, self.server.server_port)
            routes = ROUTES.get(self.path.partition("?")[0])
            if routes is None:
                raise Refused(HTTPStatus.NOT_FOUND, "there is no such page")
            if self.command not in routes:
                raise Refused(HTTPStatus.METHOD_NOT_ALLOWED, f"expected {', '.join(routes)}")
            routes[self.command](self)
        except Refused as refused:
            self.close_connection = True  # there may be a body that has not been read
            self.send(refused.text.encode(), TEXT, refused.status)

    do_GET = do_POST = answer  # noqa: N815 - names of the base class

    def send(self, body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK, policy: str = POLICY) -> None:
        """Send a whole answer."""
        self.begin(status, kind, policy)
        self.send_header("Content-Length", str(len(body)))
        if self.close_connection:
            self.send_header("Connection", "close")
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(body)

    def begin(self, status: HTTPStatus, kind: str, policy: str = POLICY) -> None:
        """Send the status and the headers that all answers have."""
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Security-Policy", policy)
        for name, value in HEADERS.items():
            self.send_header(name, value)

    def send_events(self) -> None:
        """Send an event now and after each change, until the page or the server ends."""
        self.close_connection = True
        self.begin(HTTPStatus.OK, "text/event-stream; charset=utf-8")
        self.send_header("Connection", "close")
        self.end_headers()
        self.wfile.write(f"retry: {RETRY}\n\n".encode())
        model, version = self.server.model, -1
        while not model.ended:
            shown = model.wait(version, BEAT)
            if shown is None:
                self.wfile.write(b":\n\n")
            else:
                version = shown.version
                event = {"server": self.server.run, "motion": shown.motion, "errors": list(shown.errors)}
                self.wfile.write(f"data: {json.dumps(event)}\n\n".encode())
            self.wfile.flush()

    def send_found(self, find: Callable[[Any], Any]) -> None:
        """Send what is found for the body of the request."""
        body = self.rfile.read(body_length(self.headers))
        try:
            found = find(json.loads(body))
        except Outdated:
            raise Refused(HTTPStatus.CONFLICT, "this motion has been replaced") from None
        except UsageError as error:
            raise Refused(HTTPStatus.BAD_REQUEST, str(error)) from None
        except (ValueError, RecursionError):
            raise Refused(HTTPStatus.BAD_REQUEST, "expected a JSON object") from None
        self.send(json_text(found).encode(), JSON)

    def send_error(self, code: int, message: str | None = None, explain: str | None = None) -> None:
        """Send an error that the base class has found, as plain text."""
        self.close_connection = True
        status = HTTPStatus(code)
        self.send((message or status.phrase).encode("ascii", "replace"), TEXT, status)

    def log_message(self, format: str, *args: Any) -> None:
        """Print nothing: the terminal shows what happens to the file."""


HTML = "text/html; charset=utf-8"

ROUTES: dict[str, dict[str, Callable[[ViewRequest], None]]] = {
    "/": {"GET": lambda own: own.send(own.server.page, HTML, policy=own.server.policy)},  # without a motion
    "/data": {"GET": lambda own: own.send(own.server.model.shown.motion_data.encode(), JSON)},
    "/inputs": {"GET": lambda own: own.send(json_text(own.server.hand.inputs()).encode(), JSON)},
    "/events": {"GET": ViewRequest.send_events},
    "/solve": {"POST": lambda own: own.send_found(own.server.hand.solve)},
    "/set": {"POST": lambda own: own.send_found(own.server.hand.set_parameters)},  # events report it to all pages
}
"""What is answered, by path and method."""


@contextmanager
def served(
    path: Path, changes: Mapping[str, str], assembly: str, port: int | None, settings: Mapping[str, Any], note: Notify,
    progress: Phases = no_phases,
) -> Iterator[ViewServer]:  # fmt: skip
    """Solve a model file, follow its changes and listen on a port (context manager); the caller runs the server.

    `changes` are values of dimensions by name, as for `Mechanism.with_`. Without a port it is the usual one, or a free
    one if that is in use. Raises UsageError if the given port is in use, and the errors of `LiveModel.begin`.
    """
    model = LiveModel(path, changes, assembly, settings, note)
    with bound(model, port) as server:
        model.begin(progress)
        follower = Thread(target=model.follow, name="follow the file", daemon=True)
        follower.start()
        try:
            yield server
        finally:
            model.end()
            follower.join(1.0)


def bound(model: LiveModel, port: int | None) -> ViewServer:
    """Return a server that listens on a port, or on the usual or a free one."""
    try:
        return ViewServer(model, USUAL_PORT if port is None else port)
    except OSError as error:
        if port is None:
            return ViewServer(model)
        raise UsageError(f"port {port}: {reason(error)}; choose another, or 0 for any free port") from None

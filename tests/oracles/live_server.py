"""A live view in a thread of this process, and requests to it."""

from __future__ import annotations

import json
from contextlib import closing, contextmanager
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPResponse
from threading import Thread

from gimcli.view.server import served


@dataclass(frozen=True)
class Answer:
    """Status, headers and body of an answer."""

    status: int
    headers: object
    text: str

    @property
    def json(self):
        return json.loads(self.text)


class Client:
    """Sends requests to a server; `notes` are the lines for its terminal."""

    def __init__(self, server, notes):
        self.server, self.port, self.notes = server, server.server_port, notes

    def ask(self, method, path, body=None, **headers):
        """Send a request; headers replace the usual ones, None removes one."""
        usual = {"Host": f"127.0.0.1:{self.port}"} | ({"Content-Type": "application/json"} if body is not None else {})
        sent = usual | {name.replace("_", "-"): value for name, value in headers.items()}
        data = body if isinstance(body, bytes | None) else json.dumps(body).encode()
        with closing(HTTPConnection("127.0.0.1", self.port, timeout=20)) as connection:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            if data is not None and "Content-Length" not in sent:
                connection.putheader("Content-Length", str(len(data)))
            for name, value in sent.items():
                for one in value if isinstance(value, list) else [value]:
                    if one is not None:
                        connection.putheader(name, one)
            connection.endheaders(data)
            found = connection.getresponse()
            return Answer(found.status, found.headers, found.read().decode())

    def solve(self, page="a", motion=1, **inputs):
        """Ask for a position; returns the answer's data."""
        found = self.ask("POST", "/solve", {"page": page, "motion": motion, "inputs": inputs})
        assert found.status == 200, found.text
        return found.json

    @contextmanager
    def events(self):
        """Listen to the events (context manager): an iterator of their data, without the beats."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=20)
        connection.request("GET", "/events")
        answer = connection.getresponse()
        assert answer.headers["Content-Type"].startswith("text/event-stream")
        try:
            yield _events(answer)
        finally:
            answer.close()
            connection.close()


def _events(answer: HTTPResponse):
    """Yield the events; fail where there is none between two beats, which are 10 s apart."""
    beats = 0
    while line := answer.readline():
        beats += line.startswith(b":")
        assert beats < 2, "no event"
        if line.startswith(b"data: "):
            event = json.loads(line.removeprefix(b"data: "))
            assert event.pop("server")
            beats = 0
            yield event


@contextmanager
def running(path, port=0, assembly="", changes=None, **settings):
    """Serve a model file from a thread (context manager); returns a client."""
    notes = []
    with served(path, changes or {}, assembly, port, {"steps": 24, **settings}, notes.append) as server:
        thread = Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield Client(server, notes)
        finally:
            server.shutdown()
            thread.join()

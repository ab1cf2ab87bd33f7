"""Chromium without a window, driven through the pipe of its DevTools, and a server of pages for it.

The protocol is JSON with a zero byte behind each message; it needs no library.
"""

import json
import os
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any, NamedTuple

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
PATIENCE = 60.0  # [s] for an answer
READ, WRITE = 3, 4  # where chromium has the ends of its pipes
FLAGS = (
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
    *("--remote-debugging-pipe", "--no-first-run", "--no-proxy-server", "--hide-scrollbars"),
    *("--disable-background-networking", "--disable-component-update", "--disable-extensions"),
)
WITH_PIPES = f"""
import os, sys
os.dup2(int(sys.argv[1]), {READ})
os.dup2(int(sys.argv[2]), {WRITE})
os.execv(sys.argv[3], sys.argv[3:])
"""


class Screen(NamedTuple):
    """Of a device, in the pixels of style sheets."""

    width: int
    height: int
    is_mobile: bool = False


def _by_value(expression: str) -> dict[str, Any]:
    return {"expression": expression, "returnByValue": True}


def _value(told: dict[str, Any]) -> Any:
    """What JavaScript came to."""
    assert "exceptionDetails" not in told, told
    return told["result"].get("value")


def found() -> str | None:
    """The browser's path, if there is one."""
    return next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One page of a browser, and what its console was told since it was last asked."""

    def __init__(self, path: str, profile: Path):
        theirs_in, self._out = os.pipe()
        self._in, theirs_out = os.pipe()
        starts = [sys.executable, "-c", WITH_PIPES, str(theirs_in), str(theirs_out)]
        self._process = subprocess.Popen(
            [*starts, path, *FLAGS, f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(theirs_in, theirs_out),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(theirs_in)
        os.close(theirs_out)
        self._asked, self._rest, self._session = 0, b"", ""
        self._events: list[dict[str, Any]] = []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        attached = self.ask("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(f"{domain}.enable")

    def close(self) -> None:
        """End it."""
        os.close(self._out)  # at which it leaves
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._in)

    def ask(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The result of a request of the protocol."""
        told = self.answer(method, **parameters)
        assert "error" not in told, (method, told)
        return told["result"]

    def answer(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a request, which may be an error."""
        self._asked += 1
        message: dict[str, Any] = {"id": self._asked, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE
        while True:
            told = self._next(until)
            if told.get("id") == self._asked:
                return told
            self._events.append(told)

    def show(self, screen: Screen) -> None:
        """Be a device of that size."""
        self.ask(
            "Emulation.setDeviceMetricsOverride",
            width=screen.width,
            height=screen.height,
            mobile=screen.is_mobile,
            deviceScaleFactor=1,
        )

    def open(self, url: str) -> None:
        """Go to a page and wait until all of it is loaded."""
        self.console()
        self.ask("Page.navigate", url=url)
        until = time.monotonic() + PATIENCE
        while not any(event.get("method") == "Page.loadEventFired" for event in self._events):
            self._events.append(self._next(until))

    def value(self, expression: str) -> Any:
        """What a line of JavaScript comes to."""
        return _value(self.ask("Runtime.evaluate", **_by_value(expression)))

    def wait_for(self, condition: str) -> None:
        """Come back when a line of JavaScript is true."""
        until = time.monotonic() + PATIENCE
        while True:
            told = self.answer("Runtime.evaluate", **_by_value(condition))
            if "error" not in told and _value(told["result"]):  # between two pages none answers
                return
            assert time.monotonic() < until, (condition, told)
            time.sleep(0.05)

    def console(self) -> list[str]:
        """Errors and warnings of the page since the last call."""
        self.ask("Runtime.evaluate", expression="0")  # whatever was told before has come then
        told, self._events = self._events, []
        return [text for event in told if (text := _trouble(event))]

    def picture(self) -> bytes:
        """PNG of what is seen."""
        import base64

        return base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])

    def _next(self, until: float) -> dict[str, Any]:
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], max(0.0, until - time.monotonic()))
            read = os.read(self._in, 1 << 20) if ready else b""
            assert read, "the browser has gone, or does not answer"
            self._rest += read
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)


def _trouble(event: dict[str, Any]) -> str:
    """What an event says of errors and warnings; nothing if it is none."""
    method, told = event.get("method"), event.get("params", {})
    if method == "Runtime.exceptionThrown":
        return json.dumps(told["exceptionDetails"])
    if method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
        return json.dumps(told["args"])
    if method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
        return json.dumps(told["entry"])
    return ""


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The address at which the files of a folder are served on this machine."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(_Quiet, directory=str(folder)))
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}"
    finally:
        server.shutdown()
        server.server_close()
        thread.join()

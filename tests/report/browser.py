"""A real browser for tests: Chromium over a pipe, without a package of its own."""

import base64
import json
import os
import shutil
import subprocess
import time
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome", "msedge")
FOUND = next(filter(None, map(shutil.which, NAMES)), None)


class Browser:
    """One page of a headless browser, and all that it asked the network for."""

    def __init__(self, width=1280, height=900):
        to_read, to_write = os.pipe()
        from_read, from_write = os.pipe()
        command = [
            FOUND, "--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
            "--no-first-run", "--disable-background-networking", "--remote-debugging-pipe",
            f"--window-size={width},{height}", "about:blank",
        ]  # fmt: skip

        def set_up():
            os.dup2(to_read, 103)
            os.dup2(from_write, 104)
            os.dup2(103, 3)
            os.dup2(104, 4)

        self.process = subprocess.Popen(
            command,
            preexec_fn=set_up,  # noqa: PLW1509 - no threads here
            close_fds=False,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(from_write)
        self.out, self.into = to_write, from_read
        self.rest, self.count, self.session = b"", 0, None
        self.requests, self.errors, self.events = [], [], []
        target = self.ask("Target.createTarget", url="about:blank", width=width, height=height)
        attached = self.ask("Target.attachToTarget", targetId=target["targetId"], flatten=True)
        self.session = attached["sessionId"]
        for domain in ("Page", "Network", "Runtime", "Log", "DOM"):
            self.ask(f"{domain}.enable")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.out)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.into)

    def ask(self, method, **params):
        """Return what the browser answers; what it tells meanwhile is kept."""
        self.count += 1
        wanted = {"id": self.count, "method": method, "params": params}
        if self.session:
            wanted["sessionId"] = self.session
        data = json.dumps(wanted).encode() + b"\0"
        while data:
            data = data[os.write(self.out, data) :]
        while True:
            message = self._next()
            if message.get("id") == self.count:
                assert "error" not in message, message
                return message["result"]

    def _next(self):
        while b"\0" not in self.rest:
            piece = os.read(self.into, 1 << 20)
            assert piece, "the browser has gone"
            self.rest += piece
        line, self.rest = self.rest.split(b"\0", 1)
        message = json.loads(line)
        told = message.get("method")
        if told == "Network.requestWillBeSent":
            self.requests.append(message["params"]["request"]["url"])
        elif told in {"Runtime.exceptionThrown", "Log.entryAdded"}:
            self.errors.append(message["params"])
        elif told:
            self.events.append(told)
        return message

    def open(self, path: Path, *, settle=True):
        """Open a page; return the seconds until it has settled, drawn twice."""
        self.events.clear()
        begun = time.perf_counter()
        self.ask("Page.navigate", url=path.as_uri())
        while "Page.loadEventFired" not in self.events:
            self._next()
        if settle:
            self.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
        return time.perf_counter() - begun

    def run(self, script):
        """Return the value of an expression in the page, awaited."""
        answer = self.ask(
            "Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True
        )
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def picture(self, path: Path, *, whole=False):
        """Write what is seen, or the whole page, as PNG."""
        answer = self.ask("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(answer["data"]))

    def pdf(self, path: Path):
        """Print the page."""
        answer = self.ask("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        path.write_bytes(base64.b64decode(answer["data"]))

    def greyscale(self, *, off=False):
        """See as without colours."""
        kind = "none" if off else "achromatopsia"
        self.ask("Emulation.setEmulatedVisionDeficiency", type=kind)

"""A real browser without a window, steered over the Chrome DevTools Protocol."""

import base64
import json
import os
import shutil
import subprocess
import time

#: How long something that must happen is waited for, s: only a failure takes so long.
PATIENCE = 60.0

FOUND = next(
    filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))),
    None,
)

_FLAGS = (
    "--headless=new", "--no-sandbox", "--no-first-run", "--disable-extensions",
    "--disable-dev-shm-usage", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--remote-debugging-port=0", "--remote-allow-origins=*",
)  # fmt: skip


class Browser:
    """One window on one address.

    Attributes:
        loaded: every address that the page asked for.
    """

    def __init__(self, folder, url, size=(1600, 900)):
        folder.mkdir(exist_ok=True)
        self.size = size
        self._process = subprocess.Popen(
            # It paints without a graphics card: whoever flies beside it goes first.
            ["nice", "-n", "10", FOUND, *_FLAGS, f"--user-data-dir={folder}", "about:blank"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
            env={**os.environ, "HOME": str(folder)},
        )  # fmt: skip
        self._number, self.loaded = 0, []
        try:
            self._connect(folder, url)
        except BaseException:
            self.close()
            raise

    def _connect(self, folder, url):
        from websockets.sync.client import connect

        said = folder / "DevToolsActivePort"
        wait_for(lambda: said.exists() and said.read_text().count("\n") == 1)
        port, path = said.read_text().split()
        self._wire = connect(f"ws://127.0.0.1:{port}{path}", max_size=None)
        target = self._ask("Target.createTarget", url="about:blank")["targetId"]
        self._session = None
        self._session = self._ask("Target.attachToTarget", targetId=target, flatten=True)[
            "sessionId"
        ]
        self._ask("Emulation.setDeviceMetricsOverride", width=self.size[0], height=self.size[1],
                  deviceScaleFactor=1, mobile=False)  # fmt: skip
        self._ask("Page.enable")
        self._ask("Network.enable")
        self._ask("Page.navigate", url=url)

    def _ask(self, method, **values):
        self._number += 1
        message = {"id": self._number, "method": method, "params": values}
        if getattr(self, "_session", None):
            message["sessionId"] = self._session
        self._wire.send(json.dumps(message))
        while True:
            answer = json.loads(self._wire.recv(PATIENCE))
            if answer.get("method") == "Network.requestWillBeSent":
                self.loaded.append(answer["params"]["request"]["url"])
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]

    def run(self, script):
        """The value of a JavaScript expression."""
        answer = self._ask("Runtime.evaluate", expression=script, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def shows(self, text):
        return text.lower() in self.run("document.body ? document.body.innerText : ''").lower()

    def wait_for_text(self, text):
        wait_for(lambda: self.shows(text), lambda: self.run("document.body.innerText"))

    def _middle(self, element):
        return self.run(
            f"(() => {{ const e = {element}; if (!e || e.disabled) return null;"
            " e.scrollIntoView({block: 'center', behavior: 'instant'});"
            " const r = e.getBoundingClientRect(), x = r.x + r.width / 2, y = r.y + r.height / 2;"
            " const hit = document.elementFromPoint(x, y);"
            " return r.width && hit && e.contains(hit) ? [x, y] : null; })()"
        )

    def click(self, element):
        """Presses an element with the mouse once it is there and can be pressed."""
        found = []
        wait_for(lambda: found.append(self._middle(element)) or found[-1], lambda: element)
        x, y = found[-1]
        for kind in ("mouseMoved", "mousePressed", "mouseReleased"):
            self._ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def press(self, label):
        self.click(button(label))

    def type_into(self, label, text):
        field = ("(() => { let e = [...document.querySelectorAll('label')]"
                 f".find(l => l.innerText == {label!r}); while (e && !e.querySelector('input'))"
                 " e = e.parentElement; return e && e.querySelector('input'); })()")  # fmt: skip
        self.click(field)
        self.run("document.activeElement.select()")
        self._ask("Input.insertText", text=text)
        wait_for(lambda: self.run(f"({field}).value") == text, lambda: text)

    def offers(self, label):
        """Whether a button is there and can be pressed."""
        return self.run(f"!!({button(label)}) && !({button(label)}).disabled")

    def picture(self, path):
        data = self._ask("Page.captureScreenshot", format="png")["data"]
        path.write_bytes(base64.b64decode(data))

    def close(self):
        if hasattr(self, "_wire"):
            self._wire.close()
        self._process.terminate()
        self._process.wait(PATIENCE)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def button(label):
    return f"[...document.querySelectorAll('button')].find(b => b.innerText.trim() == {label!r})"


def wait_for(what, why=lambda: ""):
    end = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < end, why()
        time.sleep(0.1)

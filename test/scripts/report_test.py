#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""report_test.py TOOLS: the report of a simulated flight in headless Chromium: no error in the
console, mouse and keyboard, widths from 360 to 2560 pixels, print. TOOLS: folder of simulate_flight
and map_recording. Exit code 77 (skipped) where Chromium or simulate_flight is missing.

KESTREL_REPORT=FILE tests a report that exists; KESTREL_SCREENSHOTS=DIR keeps pictures."""

import base64
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
TOOLS = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else pathlib.Path("/nowhere")
SKIPPED = 77
WIDTHS = (360, 768, 1280, 2560)


class Browser:
    """A page in Chromium, by the DevTools protocol over two pipes."""

    def __init__(self, folder):
        to_browser, self._write = os.pipe()
        self._read, from_browser = os.pipe()

        def connect():  # the protocol wants the file descriptors 3 and 4
            first, second = os.dup(to_browser), os.dup(from_browser)
            os.dup2(first, 3)
            os.dup2(second, 4)

        self._process = subprocess.Popen(
            [CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
             "--disable-breakpad", "--disable-dev-shm-usage", "--user-data-dir=" + folder, "--remote-debugging-pipe"],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_browser)
        os.close(from_browser)
        self._buffer, self._number, self.events = b"", 0, []
        self._session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")

    def close(self):
        """Ends all processes of Chromium: each may write into its folder until it has ended."""
        self._session = None
        try:
            self.call("Browser.close")
            self._process.wait(20)
        except (RuntimeError, OSError, subprocess.TimeoutExpired):
            pass
        self._process.kill()
        self._process.wait()
        end = time.monotonic() + 10.0
        while self._is_running() and time.monotonic() < end:
            time.sleep(0.02)
        os.close(self._write)
        os.close(self._read)

    def _is_running(self):
        """Whether a process of Chromium is left. It gets a signal that ends it."""
        try:
            os.killpg(self._process.pid, signal.SIGKILL)
        except ProcessLookupError:
            return False
        return True

    def _next(self):
        while b"\0" not in self._buffer:
            part = os.read(self._read, 1 << 16)
            if not part:
                raise RuntimeError("Chromium ended")
            self._buffer += part
        text, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(method + ": " + str(answer["error"]))
                return answer["result"]
            self.events.append(answer)

    def evaluate(self, expression):
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True,
                           awaitPromise=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(expression + ": " + str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    def wait_for(self, expression, seconds=20.0):
        end = time.monotonic() + seconds
        while not self.evaluate(expression):
            if time.monotonic() > end:
                return False
            time.sleep(0.05)
        return True

    def open(self, file, width, height=900,
             ready="typeof view !== 'undefined' && !!view.image"):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 500)
        self.call("Page.navigate", url=pathlib.Path(file).resolve().as_uri())
        return self.wait_for("document.readyState === 'complete' && " + ready)

    def frame(self):
        """Waits until what was asked for is painted."""
        self.evaluate("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=1)

    def key(self, key, text=""):
        codes = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, " ": 32,
                 "Tab": 9, "Enter": 13, "End": 35, "Home": 36}
        code = codes.get(key, ord(key) if len(key) == 1 else 0)
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, text=text,
                  windowsVirtualKeyCode=code)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, windowsVirtualKeyCode=code)

    def center(self, selector):
        """Scrolls an element into view. Returns the place of its center."""
        return self.evaluate(
            "(() => { const e = document.querySelector(%s); e.scrollIntoView({block: 'center'});"
            " const r = e.getBoundingClientRect(); return [r.x + r.width / 2, r.y + r.height / 2];"
            " })()" % json.dumps(selector))

    def problems(self):
        """Errors and warnings of the console, and exceptions."""
        self.evaluate("0")
        found = []
        for event in self.events:
            method, what = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(what["exceptionDetails"])
            if method == "Log.entryAdded" and what["entry"]["level"] in ("error", "warning"):
                found.append(what["entry"])
            if method == "Runtime.consoleAPICalled" and what["type"] in ("error", "warning"):
                found.append(what["args"])
        return found

    def screenshot(self, name):
        folder = os.environ.get("KESTREL_SCREENSHOTS")
        if not folder:
            return
        picture = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)
        (pathlib.Path(folder) / (name + ".png")).write_bytes(base64.b64decode(picture["data"]))


class ReportTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.report = os.environ.get("KESTREL_REPORT") or cls.make_report(cls.folder.name)
        cls.browser = Browser(cls.folder.name + "/profile")

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.folder.cleanup()

    @staticmethod
    def make_report(folder):
        flight = folder + "/flight.bag"
        subprocess.run([TOOLS / "simulate_flight", "--world", "laboratory", "--sensor", "urg04lx",
                        "--output", flight], check=True, stdout=subprocess.DEVNULL)
        subprocess.run([TOOLS / "map_recording", flight, "--output", folder + "/map", "--loops",
                        "use", "--quiet"], check=True)
        return folder + "/map/report.html"

    def tearDown(self):
        self.assertEqual(self.browser.problems(), [])

    def show(self, width=1280):
        self.browser.events.clear()
        self.assertTrue(self.browser.open(self.report, width), "the map is not shown")
        self.browser.frame()

    def painted(self, selector):
        """The share of the pixels of a canvas that are not transparent."""
        return self.browser.evaluate(
            "(() => { const c = document.querySelector(%s), d = c.getContext('2d')"
            ".getImageData(0, 0, c.width, c.height).data; let n = 0;"
            " for (let i = 3; i < d.length; i += 4) n += d[i] > 0; return 4 * n / d.length; })()"
            % json.dumps(selector))

    def test_fits_every_width(self):
        for width in WIDTHS:
            self.show(width)
            with self.subTest(width=width):
                over = self.browser.evaluate(
                    "document.documentElement.scrollWidth - document.documentElement.clientWidth")
                self.assertLessEqual(over, 0, "the page is wider than the screen")
                self.assertGreater(self.painted("#map"), 0.02)
                self.assertGreater(self.painted("#charts canvas"), 0.005)
                overlap = self.browser.evaluate(
                    "(() => { const a = byId('legend').getBoundingClientRect(),"
                    " b = byId('tools').getBoundingClientRect();"
                    " return a.right > b.left && a.bottom > b.top && a.top < b.bottom; })()")
                self.assertFalse(overlap, "the legend is behind the buttons")
                self.browser.screenshot("report_%d" % width)

    def test_has_the_curves_of_the_filter_and_the_parts_of_the_time(self):
        if os.environ.get("KESTREL_REPORT"):
            self.skipTest("only of the simulated flight")
        self.show()
        titles = self.browser.evaluate("data.charts.map((c) => c.title).join()")
        for title in ("Match quality", "Time per scan", "Filter: height", "Filter: tilt",
                      "Filter: bias of the gyro"):
            self.assertIn(title, titles)
        self.assertIn("matching", self.browser.evaluate("byId('summary').textContent"))
        self.assertFalse(self.browser.evaluate("byId('graphlegend').hidden"))

    def test_mouse(self):
        browser = self.browser
        self.show()
        x, y = browser.center("#map")
        scale, left = browser.evaluate("[view.scale, view.x]")
        browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-300)
        self.assertTrue(browser.wait_for("view.scale > %r" % (1.2 * scale)), "the wheel zooms")
        browser.mouse("mousePressed", x, y, button="left", clickCount=1)
        browser.mouse("mouseMoved", x + 80, y, button="left", buttons=1)
        browser.mouse("mouseReleased", x + 80, y, button="left", clickCount=1)
        self.assertNotEqual(browser.evaluate("view.x"), left, "dragging moves the map")
        browser.click(*browser.center("#reset"))
        self.assertAlmostEqual(browser.evaluate("view.scale"), scale)
        browser.mouse("mouseMoved", *browser.center("#charts canvas"))
        self.assertIn("yaw", browser.evaluate("byId('place').textContent"))
        self.assertIsNone(browser.evaluate("kept"))
        browser.click(*browser.center("#charts canvas"))
        middle = browser.evaluate("kept / data.duration")
        self.assertAlmostEqual(middle, 0.5, delta=0.05)
        browser.click(*browser.center("#reasons tbody tr"))
        self.assertEqual(browser.evaluate("kept"), browser.evaluate("data.reasons[0].first"))

    def test_play_button(self):
        browser = self.browser
        self.show()
        browser.click(*browser.center("#play"))
        self.assertTrue(browser.wait_for("kept > 0.02 * data.duration"), "the time goes on")
        self.assertEqual(browser.evaluate("byId('play').textContent"), "Stop")
        self.assertGreaterEqual(browser.evaluate("view.marker"), 0)
        browser.click(*browser.center("#play"))
        at = browser.evaluate("kept")
        browser.frame()
        self.assertEqual(browser.evaluate("kept"), at, "it stopped")
        browser.evaluate("showTime(data.duration * 0.99, true)")
        browser.click(*browser.center("#play"))
        self.assertTrue(browser.wait_for("!player.running"), "it ends with the flight")

    def test_keyboard(self):
        browser = self.browser
        self.show()
        seen = set()
        for _ in range(30):
            browser.key("Tab")
            seen.add(browser.evaluate("document.activeElement.id || document.activeElement.tagName"))
        self.assertTrue({"map", "play", "reset", "CANVAS"} <= seen, seen)
        browser.evaluate("byId('map').focus()")
        scale, left = browser.evaluate("[view.scale, view.x]")
        browser.key("+", "+")
        self.assertGreater(browser.evaluate("view.scale"), scale)
        browser.key("ArrowRight")
        self.assertGreater(browser.evaluate("view.x"), left)
        browser.key("0", "0")
        self.assertAlmostEqual(browser.evaluate("view.scale"), scale)
        browser.key(" ", " ")
        self.assertTrue(browser.wait_for("player.running && kept > 0"))
        browser.key(" ", " ")
        self.assertFalse(browser.evaluate("player.running"))
        browser.evaluate("document.querySelector('#charts canvas').focus()")
        browser.key("Home")
        browser.key("ArrowRight")
        self.assertAlmostEqual(browser.evaluate("kept / data.duration"), 0.01, places=3)
        browser.key("End")
        self.assertEqual(browser.evaluate("kept"), browser.evaluate("data.duration"))

    def test_print_and_dark_colors(self):
        browser = self.browser
        self.show()
        pdf = base64.b64decode(browser.call("Page.printToPDF", printBackground=True)["data"])
        self.assertTrue(pdf.startswith(b"%PDF"))
        self.assertGreater(len(pdf), 20000, "with map and charts")
        if os.environ.get("KESTREL_SCREENSHOTS"):
            (pathlib.Path(os.environ["KESTREL_SCREENSHOTS"]) / "report.pdf").write_bytes(pdf)
        browser.call("Emulation.setEmulatedMedia", media="print")
        hidden = "getComputedStyle(byId('tools')).display === 'none'"
        self.assertTrue(browser.evaluate(hidden), "no buttons on paper")
        browser.call("Emulation.setEmulatedMedia", media="",
                     features=[{"name": "prefers-color-scheme", "value": "dark"}])
        browser.frame()
        self.assertEqual(browser.evaluate("color('page')"), "#12161d")
        self.assertGreater(self.painted("#map"), 0.02)
        browser.screenshot("report_dark")
        browser.call("Emulation.setEmulatedMedia", media="", features=[])


if __name__ == "__main__":
    if not CHROMIUM:
        print("skipped: chromium is not installed (apt-get install chromium)")
        sys.exit(SKIPPED)
    if not os.environ.get("KESTREL_REPORT") and not (TOOLS / "simulate_flight").exists():
        print("skipped: there is no simulate_flight in " + str(TOOLS))
        sys.exit(SKIPPED)
    unittest.main(argv=sys.argv[:1])

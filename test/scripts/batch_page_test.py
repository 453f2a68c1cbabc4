#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""The page of map_batch (index.html) in headless Chromium: no error in the console, sorting by mouse
and keyboard, the filter, widths from 360 to 2560 pixels, print. Exit code 77 (skipped) where
Chromium is missing. KESTREL_SCREENSHOTS=DIR keeps pictures."""

import base64
import os
import pathlib
import sys
import unittest

from map_batch_test import Batch
from report_test import CHROMIUM, SKIPPED, WIDTHS, Browser

LONG = "a_recording_with_a_name_that_is_much_longer_than_the_screen_of_a_telephone_is_wide_2026-11-29"


class BatchPage(Batch):
    def setUp(self):
        super().setUp()
        for name, error in (("first", 10), ("second", 30), ("third", 20), (LONG, 40)):
            self.log(name + ".clf", error)
        self.batch()
        self.out.rename(self.folder / "old")
        self.log("second.clf", 60)
        self.log("broken.clf")
        self.batch("--compare", str(self.folder / "old"), "--max-relations", "0.05", code=3)
        self.browser = Browser(str(self.folder / "profile"))

    def tearDown(self):
        problems = self.browser.problems()
        self.browser.close()
        super().tearDown()
        self.assertEqual(problems, [])

    def show(self, width):
        self.assertTrue(self.browser.open(self.out / "index.html", width, ready="!!sortBy"))
        self.browser.frame()

    def shown(self):
        return self.browser.evaluate(
            "[...document.querySelectorAll('#recordings tbody tr')].filter(r => !r.hidden)"
            ".map(r => r.cells[1].textContent)")

    def test_fits_every_width(self):
        for width in WIDTHS:
            self.show(width)
            with self.subTest(width=width):
                self.assertLessEqual(self.browser.evaluate(
                    "document.documentElement.scrollWidth - document.documentElement.clientWidth"), 0)
                self.assertTrue(self.browser.evaluate(
                    "[...document.images].every(i => i.complete && i.naturalWidth > 0)"))
                self.assertGreater(self.browser.evaluate(
                    "document.querySelector('.worse .soft').getBoundingClientRect().width"), 150,
                                   "why a recording failed can be read")
                self.browser.screenshot(f"batch_{width}")

    def test_sorts_and_filters(self):
        self.show(1280)
        title = "#recordings th:nth-child(4) button"
        self.assertIn("relations", self.browser.evaluate(
            f"document.querySelector('{title}').textContent"))
        self.browser.click(*self.browser.center(title))
        self.assertEqual(self.shown(), ["second", LONG, "third", "first", "broken"])
        self.browser.evaluate(f"document.querySelector('{title}').focus()")
        self.browser.key("Enter", "\r")
        self.assertEqual(self.shown(), ["first", "third", LONG, "second", "broken"])
        self.browser.evaluate("document.getElementById('filter').focus()")
        for letter in "ir":
            self.browser.key(letter, letter)
        self.assertEqual(self.shown(), ["first", "third"])

    def test_worse_results_come_first(self):
        self.show(1280)
        first = "document.querySelector('.sortable tbody tr').textContent"
        self.assertIn("second", self.browser.evaluate(first))
        self.assertIn("worse", self.browser.evaluate(first))

    def test_print(self):
        self.show(1280)
        pdf = base64.b64decode(self.browser.call("Page.printToPDF", preferCSSPageSize=True)["data"])
        self.assertTrue(pdf.startswith(b"%PDF"))
        if os.environ.get("KESTREL_SCREENSHOTS"):
            (pathlib.Path(os.environ["KESTREL_SCREENSHOTS"]) / "batch.pdf").write_bytes(pdf)
        self.browser.call("Emulation.setEmulatedMedia", media="print")
        self.browser.call("Emulation.setDeviceMetricsOverride", width=980, height=700,
                          deviceScaleFactor=1, mobile=False)  # a sheet of paper
        self.browser.frame()
        cut = self.browser.evaluate(
            "[...document.querySelectorAll('table')].some(t => t.getBoundingClientRect().right >"
            " document.documentElement.clientWidth)")
        self.assertFalse(cut, "a table is wider than the paper")


if __name__ == "__main__":
    if not CHROMIUM:
        print("skipped: chromium is not installed (apt-get install chromium)")
        sys.exit(SKIPPED)
    del Batch  # its tests are those of map_batch_test.py
    unittest.main()

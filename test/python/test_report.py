import base64
import json
import os
import re
import unittest
from html.parser import HTMLParser
from xml.etree import ElementTree

import support
from straight_run import StraightRun

VOID = {"meta", "img", "br", "hr", "link"}
NASTY = """<script>alert("1")</script> & 'x'"""


class Page(HTMLParser):
    """What a page holds: its elements with their attributes, its text, and whether they are closed in order."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.open, self.text = [], [], ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, (tag, self.open)
        self.open.pop()

    def handle_data(self, data):
        if not self.open or self.open[-1] != "style":
            self.text += data + " "

    def of(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


class Report(StraightRun):
    def setUp(self):
        super().setUp()
        self.path = os.path.join(self.folder, "report.html")

    def write_provenance(self, **changes):
        summary = {"bag": "drive one.bag", "finished": "2020-01-02T03:04:05Z", "detections": {"matched": 7, "gate": 1},
                   "messages": {"odometry": 400}, "messages_refused": {"odometry: frame": 3}, "update_ms_mean": 0.25,
                   "warnings": ["time went back"], "versions": {"kinect_ekf_slam": "9.8.7"}, **changes}
        support.write(self.folder, "summary.json", json.dumps(summary))
        support.write(self.folder, "parameters.yaml", "mode: slam\ninput: {max_linear_speed: 0.220}\n"
                      "estimator:\n  type: ukf\n  seed: 77\nframes: {static_transforms: [{parent: a}]}\n")

    def report(self, *options):
        process = support.run_script("evaluate.py", self.folder, "--report", *options)
        self.assertEqual(process.returncode, 0, process.stderr)
        with open(self.path, encoding="utf-8") as file:
            text = file.read()
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assert_needs_nothing_else(page, text)
        return page

    def assert_needs_nothing_else(self, page, text):
        """No element asks for anything outside of the page, and a browser is told to allow none."""
        for tag, attributes in page.elements:
            self.assertNotIn(tag, ("script", "link", "iframe", "object", "base"))
            for name in ("src", "href", "srcset", "action", "data", "background"):
                self.assertTrue(attributes.get(name, "data:").startswith("data:"), attributes.get(name, "")[:60])
        self.assertNotIn("url(", text)
        self.assertNotIn("@import", text)
        policy = [m["content"] for m in page.of("meta") if m.get("http-equiv") == "Content-Security-Policy"]
        self.assertIn("default-src 'none'", policy[0])

    def test_holds_figures_pictures_parameters_versions_and_warnings(self):
        self.write_provenance()
        page = self.report("--truth", self.bag)
        for part in ("SLAM run run", "drive one.bag", "2020-01-02T03:04:05Z", "ukf", "9.8.7", "time went back",
                     "3 messages refused: odometry: frame", "matched 7, gate 1", "0.25 ms", "0.100 m", "1.719 deg",
                     "True landmarks without an estimate: 25", "spurious", "Matplotlib",
                     "slam_replay 'drive one.bag' --config"):
            self.assertIn(part, page.text)
        images = page.of("img")
        self.assertEqual(len(images), 3)
        for image in images:
            picture = ElementTree.fromstring(base64.b64decode(image["src"].split("base64,")[1]))
            self.assertTrue(picture.tag.endswith("svg"))
            references = [value for element in picture.iter() for name, value in element.attrib.items()
                          if name.endswith("href")]
            self.assertEqual([value for value in references if not value.startswith(("#", "data:"))], [])

    def test_marks_the_parameters_that_are_not_the_defaults(self):
        self.write_provenance()
        self.report("--truth", self.bag)
        with open(self.path, encoding="utf-8") as file:
            text = file.read()
        self.assertEqual(re.findall(r"<th>(\w+)</th><td><b>([^<]*)</b> <span class=\"none\">\(([^<]*)\)", text), [
            ("type", "ukf", "invariant_ekf"), ("seed", "77", "built in"),
            ("static_transforms", "[{&#34;parent&#34;: &#34;a&#34;}]", "built in")])
        self.assertIn("<th>max_linear_speed</th><td>0.220</td>", text)   # the default, written otherwise

    def test_escapes_every_text(self):
        self.write_provenance(bag=NASTY, warnings=[NASTY], versions={NASTY: NASTY}, messages={NASTY: 1},
                              messages_refused={NASTY: 2}, finished=NASTY, detections={NASTY: 3})
        with open(os.path.join(self.folder, "parameters.yaml"), "a", encoding="utf-8") as file:
            file.write(json.dumps(NASTY) + ": {" + json.dumps(NASTY) + ": " + json.dumps(NASTY) + "}\n")
        with open(os.path.join(self.folder, "landmarks.csv"), "a", encoding="utf-8") as file:
            file.write('9,"' + NASTY.replace('"', '""') + '",0,0,0,0.01,0,0,0.02,0,0,1\n')
        page = self.report("--truth", self.bag, "--title", NASTY)
        self.assertEqual(page.of("script"), [])
        self.assertGreaterEqual(page.text.count(NASTY), 12)

    def test_without_truth(self):
        self.write_provenance()
        for name in ("evaluation.json", "evaluation.png"):
            support.write(self.folder, name, "of an evaluation before")
        page = self.report()
        for name in ("evaluation.json", "evaluation.png"):
            with open(os.path.join(self.folder, name), encoding="utf-8") as file:
                self.assertEqual(file.read(), "of an evaluation before")
        self.assertIn("There is no truth to compare with", page.text)
        self.assertIn("Not known: ate_rmse_m", page.text)
        self.assertNotIn("aligned by", page.text)
        self.assertIn("evaluate.py repeated --report", page.text)
        self.assertNotIn("true identity", page.text)

    def test_of_a_run_with_nothing_but_its_path(self):
        """An old run, or that of another program."""
        support.write(self.folder, "landmarks.csv", "id,label,x,y,z,cxx,cxy,cxz,cyy,cyz,czz,observations\n")
        support.write(self.folder, "associations.csv", "t,detection,source_id,verdict,landmark,nis\n")
        for name in ("trajectory_covariance.csv", "dead_reckoning.tum", "associations_instant.csv"):
            os.remove(os.path.join(self.folder, name))
        for options in ((), ("--truth", self.bag)):
            page = self.report(*options)
            for part in ("no parameters.yaml", "no trajectory_covariance.csv", "The map has no landmarks",
                         "Not recorded."):
                self.assertIn(part, page.text)

    def test_bad_provenance_is_one_line_and_leaves_the_old_page(self):
        for name, text, expected in (("summary.json", "{", ("summary.json", "not JSON")),
                                     ("summary.json", "[1]", ("summary.json", "not a JSON object")),
                                     ("parameters.yaml", "a: [", ("parameters.yaml", "not YAML")),
                                     ("parameters.yaml", "- a\n", ("parameters.yaml", "map of parameter groups"))):
            self.write_provenance()
            support.write(self.folder, "report.html", "old")
            support.write(self.folder, name, text)
            process = support.run_script("evaluate.py", self.folder, "--truth", self.bag, "--report")
            support.assert_one_line_error(self, process, *expected)
            with open(self.path, encoding="utf-8") as file:
                self.assertEqual(file.read(), "old")

    def test_a_summary_with_other_types_than_expected_is_as_if_it_were_not_there(self):
        self.write_provenance(bag=5, warnings="all", versions=[], messages=3, update_ms_mean="fast", finished={})
        self.report("--truth", self.bag)


if __name__ == "__main__":
    unittest.main()

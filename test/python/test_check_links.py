"""check_links.py finds links that lead nowhere, and no others."""
import os
import tempfile
import unittest

from support import run_script

PAGE = """# One page
## A `heading`, twice: yes!
## A heading, twice: yes
[file](other.md) [anchor](#a-heading-twice-yes) [second](#a-heading-twice-yes-1) [theirs](other.md#far-away) [web](https://example.org/x)
`[code](none.md)`
```
[block](none.md)
```
"""


class CheckLinks(unittest.TestCase):
    def check(self, text):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "other.md"), "w", encoding="utf-8") as file:
                file.write("# Far away\n")
            page = os.path.join(folder, "page.md")
            with open(page, "w", encoding="utf-8") as file:
                file.write(text)
            return run_script("check_links.py", page)

    def test_links_that_lead_somewhere(self):
        self.assertEqual(self.check(PAGE).returncode, 0, self.check(PAGE).stdout)

    def test_a_missing_file_a_missing_anchor_and_a_missing_picture(self):
        for link in ("[a](missing.md)", "[a](other.md#near)", "[a](#nowhere)", "![a](missing.png)"):
            with self.subTest(link):
                process = self.check(PAGE + link)
                self.assertEqual(process.returncode, 1)
                self.assertRegex(process.stdout, r"page.md:9: \S+: (there is no such file|no heading has that anchor)\n$")


if __name__ == "__main__":
    unittest.main()

"""The little of GitHub's Markdown that the tools of the documentation need to know."""
import re

LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^()\s]+)(?:\s+\"[^\"]*\")?\)")
HEADING = re.compile(r"^(#+) +(.*?) *#*$", re.MULTILINE)
_BLOCK = re.compile(r"^```.*?^```$", re.DOTALL | re.MULTILINE)
_CODE = re.compile(_BLOCK.pattern + r"|`[^`\n]+`", re.DOTALL | re.MULTILINE)


def _outside(pattern, text, change):
    parts, end = [], 0
    for code in pattern.finditer(text):
        parts += [change(text[end:code.start()]), code.group()]
        end = code.end()
    return "".join(parts) + change(text[end:])


def outside_blocks(text, change):
    """`text` with `change` applied to what is not in fenced blocks of code."""
    return _outside(_BLOCK, text, change)


def outside_code(text, change):
    """Likewise, and not in code spans."""
    return _outside(_CODE, text, change)


def without_code(text):
    """Code is taken out; lines stay where they are."""
    return _CODE.sub(lambda code: "\n" * code.group().count("\n"), text)


def _plain_anchor(heading):
    text = LINK.sub(r"\2", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def anchors(text):
    """GitHub's anchors of the headings, in their order; the second of the same text is numbered."""
    found = []
    for _, heading in HEADING.findall(_BLOCK.sub("", text)):
        anchor, number = _plain_anchor(heading), 1
        while anchor in found:
            anchor, number = f"{_plain_anchor(heading)}-{number}", number + 1
        found.append(anchor)
    return found

"""One row of the table of faults."""
import dataclasses


@dataclasses.dataclass
class Row:
    fault: str        # what is done to the package
    count: str        # how often
    must_hold: str
    result: str       # what came of it, in figures
    holds: bool

    def cells(self):
        return self.fault, self.count, self.must_hold, ("" if self.holds else "**does not hold**: ") + self.result


def table(rows):
    """GitHub's Markdown."""
    lines = [("fault", "how many", "what must hold", "result"), ("---",) * 4, *(row.cells() for row in rows)]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def number(count):
    return f"{count:,}"

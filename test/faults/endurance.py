"""Long runs."""
from programs import run
from row import Row, number


def patrol(quick):
    minutes = 24 if quick else 480
    code, text = run("slam_study", "patrol", "--minutes", str(minutes))
    lines = text.strip().splitlines()
    rows = [line.split() for line in lines if len(line.split()) == 4 and line.split()[0].isdigit()]
    if code != 0 or not rows:
        return Row("a long run at speed", f"{minutes} simulated minutes", "", f"exit code {code}", False)
    first, last = rows[0], rows[-1]
    result = (f"landmarks {first[1]} to {last[1]}, memory {first[2]} to {last[2]} MB, time per update {first[3]} to {last[3]} ms "
              f"(first to last of {number(len(rows))} equal parts)")
    return Row("one run round and round, at speed", f"{minutes / 60:g} simulated hours" if minutes >= 60 else f"{minutes} simulated minutes",
               "map, memory and time per update stay as they are", result, lines[-1].startswith("flat"))

"""What the scripts share that draw what a study of `slam_study --json` wrote."""
import json

from . import cli


def draw_study(study, description, draw):
    """Reads the results' file that the command line names and calls draw(results, path of the PNG)."""
    parser = cli.ArgumentParser(description=description)
    parser.add_argument("results", metavar="FILE.json", help=f"what slam_study {study} --json wrote")
    parser.add_argument("picture", metavar="PICTURE.png", help="PNG to write")
    arguments = parser.parse_args()
    with open(arguments.results, encoding="utf-8", errors="replace") as file:
        text = file.read()
    with cli.atomic_output(arguments.picture) as path:
        try:
            draw(json.loads(text), path)
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            raise cli.InputError(f"{arguments.results}: not what slam_study {study} --json writes "
                                 f"({' '.join(repr(error).split())})") from None
    print(arguments.picture)

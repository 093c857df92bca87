"""What all scripts do alike: one-line errors, exit code 2, atomic output files, progress on a terminal."""
import argparse
import contextlib
import os
import sys
import time


class InputError(Exception):
    """Unusable input. The text is one line: what is wrong, where, and what would be right."""


class ArgumentParser(argparse.ArgumentParser):
    """Help keeps its line breaks; an error is one line."""

    def __init__(self, **options):
        super().__init__(formatter_class=argparse.RawDescriptionHelpFormatter, **options)

    def error(self, message):
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")


def run(main):
    """Calls `main()` and turns unusable input into one line and exit code 2."""
    try:
        sys.exit(main())
    except (InputError, OSError) as error:
        text = str(error)
        if isinstance(error, OSError) and error.filename is not None:
            text = f"{error.filename}: {error.strerror}"
        print(f"{os.path.basename(sys.argv[0])}: error: {text}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)


@contextlib.contextmanager
def atomic_output(path):
    """Yields a temporary path in the same folder that becomes `path` only when the block succeeds."""
    folder, name = os.path.split(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise InputError(f"{path}: its folder does not exist; create {folder} first")
    if os.path.isdir(path):
        raise InputError(f"{path}: is a folder; a file name is needed")
    temporary_path = os.path.join(folder, f".{name}.{os.getpid()}.tmp")
    try:
        yield temporary_path
        os.replace(temporary_path, path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.remove(temporary_path)


def progress(items, total, what):
    """Passes the items on and shows how far it is, on a terminal only."""
    if not sys.stderr.isatty():
        yield from items
        return
    shown = 0.0
    for count, item in enumerate(items):
        now = time.monotonic()
        if now - shown > 0.1:
            shown = now
            print(f"\r{what} {100 * count // max(total, 1):3d} %", end="", file=sys.stderr, flush=True)
        yield item
    print("\r\033[K", end="", file=sys.stderr, flush=True)

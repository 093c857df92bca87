"""Tables of numbers and text in files, with errors that name the file and the line."""
import csv
import os

import numpy as np

from .cli import InputError

LARGEST = 1e12   # in size: more than any number of a run, and few enough digits to calculate with


def read_numbers(path, columns, separator=None, header=False, ordered_by_time=False):
    """The numbers of a text file as an array with one row per line.

    columns: names of the columns, for the errors; separator: None for white space;
    header: the first line holds the names; `#` starts a comment.
    """
    _require_file(path)
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            if header:
                _check_header(path, file.readline().rstrip("\r\n").split(separator), columns)
            rows = [line for line in file if not line.isspace() and not line.lstrip().startswith("#")]
        table = np.loadtxt(rows, delimiter=separator, ndmin=2) if rows else np.empty((0, len(columns)))
        damaged = table.shape[1] != len(columns) or not (np.abs(table) <= LARGEST).all()
    except ValueError:
        damaged = True
    if damaged:
        raise InputError(_first_damage(path, columns, separator, header))
    if ordered_by_time and (np.diff(table[:, 0]) < 0).any():
        row = int(np.argmax(np.diff(table[:, 0]) < 0)) + 1
        raise InputError(f"{path}:{_line_of_row(path, row, header)}: time {table[row, 0]:.3f} comes after "
                         f"{table[row - 1, 0]:.3f}; rows in the order of time are needed")
    return table


def read_csv(path, columns, numeric):
    """The rows of a comma-separated file with a header line, as one dictionary {column: value} per row.

    columns: names that have to be there; numeric: those of them that hold numbers (an empty field is NaN).
    """
    _require_file(path)
    rows = []
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.reader(file)
        names = next(reader, [])
        _check_header(path, names, columns, others_allowed=True)
        for fields in reader:
            if not fields:
                continue
            if len(fields) != len(names):
                raise InputError(f"{path}:{reader.line_num}: {len(fields)} fields; "
                                 f"{len(names)} are needed: {','.join(names)}")
            row = dict(zip(names, fields))
            for name in numeric:
                try:
                    row[name] = float(row[name]) if row[name].strip() else float("nan")
                except ValueError:
                    raise InputError(f"{path}:{reader.line_num}: {name} is '{row[name]}'; "
                                     "a number is needed") from None
                if abs(row[name]) > LARGEST:
                    raise InputError(f"{path}:{reader.line_num}: {name} is {row[name]:g}; "
                                     f"a number of at most {LARGEST:g} in size is needed")
            row["line"] = reader.line_num
            rows.append(row)
    return rows


def _require_file(path):
    if not os.path.isfile(path):
        raise InputError(f"{path}: no such file")
    if os.path.getsize(path) == 0:
        raise InputError(f"{path}: the file is empty")


def _check_header(path, names, columns, others_allowed=False):
    names = [name.strip() for name in names]
    if (set(columns) <= set(names)) if others_allowed else names == list(columns):
        return
    raise InputError(f"{path}:1: header is '{','.join(names)[:60]}'; '{','.join(columns)}' is needed")


def _data_lines(path, header):
    with open(path, encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, 1):
            if not (header and number == 1) and not line.isspace() and not line.lstrip().startswith("#"):
                yield number, line


def _line_of_row(path, row, header):
    for index, (number, _) in enumerate(_data_lines(path, header)):
        if index == row:
            return number
    return 0


def _first_damage(path, columns, separator, header):
    needed = f"{len(columns)} finite numbers, at most {LARGEST:g} in size, are needed: {' '.join(columns)}"
    for number, line in _data_lines(path, header):
        fields = line.split("#")[0].split(separator)
        try:
            if len(fields) != len(columns) or not (np.abs([float(field) for field in fields]) <= LARGEST).all():
                raise ValueError
        except ValueError:
            shown = line.strip()
            return f"{path}:{number}: damaged row '{shown[:60]}'; {needed}"
    return f"{path}: damaged; {needed}"

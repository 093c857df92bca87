"""How a run came about: its input, its parameters, what was said of them, and the versions it was made with."""
import json
import os
from dataclasses import dataclass
from typing import Any, Dict, Optional

import yaml

from .cli import InputError
from .environment import package_file


@dataclass(frozen=True)
class Provenance:
    """summary: summary.json, {} where there is none; parameters: {group/key: text}, None where not recorded."""
    summary: Dict[str, Any]
    parameters: Optional[Dict[str, str]]

    def of(self, name, kind, default):
        """An entry of the summary, the default where it is missing or not of that kind."""
        value = self.summary.get(name)
        return value if isinstance(value, kind) and not isinstance(value, bool) else default


def read_provenance(folder):
    return Provenance(_read_summary(os.path.join(folder, "summary.json")),
                      read_parameters(os.path.join(folder, "parameters.yaml")))


def read_parameters(path):
    """{group/key: text as it is written} of a YAML file of parameter groups; None without the file."""
    if not os.path.exists(path):
        return None
    try:
        with open(path, encoding="utf-8") as file:
            groups = yaml.load(file, Loader=yaml.BaseLoader) or {}
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    if not isinstance(groups, dict):
        raise InputError(f"{path}: not a YAML map of parameter groups")
    return dict(_flattened(groups))


def default_parameters():
    return read_parameters(package_file("config", "slam.yaml"))


def is_same_value(a, b):
    """Whether two texts of a parameter, None where there is none, stand for the same value."""
    try:
        return float(a) == float(b)
    except (TypeError, ValueError):
        return a == b


def _flattened(groups, prefix=""):
    for key, value in groups.items():
        if isinstance(value, dict):
            yield from _flattened(value, f"{prefix}{key}/")
        else:
            yield f"{prefix}{key}", value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _read_summary(path):
    if not os.path.exists(path):
        return {}
    try:
        with open(path, encoding="utf-8") as file:
            summary = json.load(file)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON: {error}") from None
    if not isinstance(summary, dict):
        raise InputError(f"{path}: not a JSON object; what slam_replay or record_run.py writes is needed")
    return summary

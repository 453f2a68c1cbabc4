# SPDX-License-Identifier: BSD-3-Clause
"""The programs of the package that map_batch starts, and files that a killed process cannot halve."""

import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys

from . import BatchError

USED = ("map_recording", "evaluate_trajectory", "recording_info")


def find_tools(script):
    """The folder of the programs: $KESTREL_TOOLS, that of map_batch itself, or one in PATH."""
    folders = [pathlib.Path(name).resolve().parent for name in (sys.argv[0], script)]
    if "KESTREL_TOOLS" in os.environ:
        folders = [pathlib.Path(os.environ["KESTREL_TOOLS"]).resolve()]
    elif shutil.which(USED[0]):
        folders.append(pathlib.Path(shutil.which(USED[0])).resolve().parent)
    for folder in folders:
        if all((folder / name).is_file() for name in USED):
            return folder
    raise BatchError(f"{', '.join(USED)} are not in {' or '.join(map(str, folders))}; "
                     "build and install the package")


def hash_of_tools(folder):
    """Other programs give other results."""
    digest = hashlib.sha256()
    for name in USED:
        digest.update((folder / name).read_bytes())
    return digest.hexdigest()


def require_valid_options(tools, options):
    """An option or parameter that is wrong is wrong for every recording: say so at once."""
    run = subprocess.run([str(tools / "map_recording"), "--list-parameters", *options],
                         capture_output=True, text=True, check=False)
    if run.returncode != 0:
        lines = (run.stderr or run.stdout).strip().splitlines() or ["unknown error"]
        raise BatchError(f"map_recording refuses the options: {lines[0]}")


def write_file(path, text):
    """Replaces the file in one step."""
    path = pathlib.Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_text(text, encoding="utf-8")
    os.replace(temporary, path)


def write_json(path, value):
    write_file(path, json.dumps(value, indent=2) + "\n")


def read_json(path):
    """None if the file is missing or broken."""
    try:
        return json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None

#!/usr/bin/env python3
"""Compiles every header of app, core and ui by itself, without precompiled headers: whoever includes it needs nothing
before it. Syntax only, with the options of a source of the same folder.

    tests/structure/check_headers.py BUILD_FOLDER [HEADER ...]

Exit code 1 where a header does not compile alone. About a second of processor time a header.
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# Compiled by a source several times, for one instruction set each (Highway); or by nvcc alone.
NOT_ALONE = re.compile(r"-inl\.h$|/cuda_launch(ers)?\.h$|/fragments\.h$")
# Of a source's command: the precompiled header, the output, what the target alone defines.
DROPPED = {"-include": 2, "-o": 2, "-c": 2, "-Winvalid-pch": 1, "-fpch-preprocess": 1}


def options_by_folder(build):
    """The compiler and its options of one source in each folder; sources compiled together count for all of theirs."""
    found = {}
    with open(os.path.join(build, "compile_commands.json"), encoding="utf-8") as file:
        for entry in json.load(file):
            sources = [entry["file"]]
            if "/Unity/" in entry["file"]:
                with open(entry["file"], encoding="utf-8") as unity:
                    sources = re.findall(r'#include "([^"]+)"', unity.read())
            words, kept = shlex.split(entry["command"]), []
            while words:
                if words[0] in DROPPED:
                    del words[: DROPPED[words[0]]]
                elif os.path.basename(words[0]) == "ccache":
                    del words[0]
                else:
                    kept.append(words.pop(0))
            for source in sources:  # a folder of several targets: the one that sees the most
                folder = os.path.relpath(os.path.dirname(source), ROOT)
                if kept.count("-isystem") >= found.get(folder, []).count("-isystem"):
                    found[folder] = kept
    return found


def options_for(header, found):
    folder = os.path.dirname(header)
    while folder not in found and folder:
        folder = os.path.dirname(folder)
    return found.get(folder) or found["core/base"]


def compiles_alone(header, found):
    command = options_for(header, found) + ["-fsyntax-only", "-x", "c++", "-"]
    result = subprocess.run(command, input=f'#include "{header}"\n', capture_output=True, text=True, cwd=ROOT, check=False)
    return header, result.returncode == 0, result.stderr


def main():
    if len(sys.argv) < 2:
        print(__doc__)
        return 2
    found = options_by_folder(sys.argv[1])
    headers = sys.argv[2:]
    if not headers:
        for top in ("app", "core", "ui"):
            for folder, _, names in os.walk(os.path.join(ROOT, top)):
                headers += [os.path.relpath(os.path.join(folder, name), ROOT) for name in sorted(names) if name.endswith(".h")]
        headers = [header for header in headers if not NOT_ALONE.search(header)]
    broken = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for header, alone, said in pool.map(lambda header: compiles_alone(header, found), headers):
            if not alone:
                broken += 1
                print(f"{header} does not compile by itself:\n{said}")
    print(f"{len(headers) - broken} of {len(headers)} headers compile by themselves")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())

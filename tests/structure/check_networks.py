#!/usr/bin/env python3
"""Checks that packaging/networks makes the files that core/network/installed_networks.cpp accepts, and no others.

Exit code 1 where the two differ in a file's name or in its SHA-256.
"""
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
MADE = re.compile(r'^\s*"(\w+\.onnx) ([0-9a-f]{64}) \S+"$', re.MULTILINE)
ACCEPTED = re.compile(r'"(\w+\.onnx)",[^{}]*?"([0-9a-f]{64})"')


def read_pairs(path, pattern):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return dict(pattern.findall(file.read()))


def main():
    made = read_pairs("packaging/networks", MADE)
    accepted = read_pairs("core/network/installed_networks.cpp", ACCEPTED)
    problems = [] if made and accepted else ["no network was found in one of the two"]
    for name in sorted(set(made) | set(accepted)):
        if made.get(name) != accepted.get(name):
            problems.append(f"{name}: packaging/networks makes {made.get(name)}, the program accepts {accepted.get(name)}")
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

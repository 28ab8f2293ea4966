#!/usr/bin/env python3
"""Checks the layers: every #include of app, core and ui against the table of rooms in docs/ARCHITECTURE.md.

A room may include only what the table's third column lists for it, and only rooms above it in the table; the table
lists nothing that no file needs. Folders do not include each other, nor do sources, each taken together with its
header, but for the circles listed below. Prints the floors (a room stands one above the highest room it uses), the
lines of each room, and the longest files and functions. Exit code 1 where something is wrong.

    tests/structure/check_includes.py [--quiet]
"""
import collections
import os
import re
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
INCLUDE = re.compile(r'^\s*#\s*include\s+"((?:app|core|ui)/[^"]+)"', re.MULTILINE)
OUTSIDE = ("app", "ui", "cuda")  # stand above the rooms, which include none of them
# Longer than this a file surely has two ideas.
MOST_LINES = 600
# Sources that may include each other, as circles() finds them, and why.
ALLOWED_CIRCLES = {
    ("core/papers/dense_product", "core/papers/dense_product-inl"):
        "the -inl file is the body of the pair, compiled once for each instruction set",
}


def read_table():
    """Rooms in the table's order, each with the rooms that its row says it uses."""
    rooms = {}
    with open(os.path.join(ROOT, "docs", "ARCHITECTURE.md"), encoding="utf-8") as page:
        for line in page:
            row = re.match(r"^\| `([a-z/]+)` \|.*\|([^|]*)\|\s*$", line)
            if row:
                rooms[row.group(1)] = set(re.findall(r"`([a-z/]+)`", row.group(2)))
    return rooms


def room_of(path, rooms):
    top, _, rest = path.partition("/")
    if top in OUTSIDE:
        return top
    if rest.startswith("cuda/"):
        return "cuda"
    folder = os.path.dirname(rest)
    while folder and folder not in rooms:
        folder = os.path.dirname(folder)
    return folder or rest.split("/")[0]


def sources():
    for top in ("core", "ui", "app"):
        for folder, _, names in os.walk(os.path.join(ROOT, top)):
            for name in sorted(names):
                if name.endswith((".h", ".cpp", ".cu")):
                    yield os.path.relpath(os.path.join(folder, name), ROOT)


def circles(graph):
    """Sets of nodes that reach each other (Tarjan)."""
    index, low, stack, found = {}, {}, [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        for to in sorted(graph[node]):
            if to not in index:
                visit(to)
                low[node] = min(low[node], low[to])
            elif to in stack:
                low[node] = min(low[node], index[to])
        if low[node] == index[node]:
            at = stack.index(node)
            if len(stack) - at > 1:
                found.append(sorted(stack[at:]))
            del stack[at:]

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return found


def functions(text):
    """Name and lines of each function; clang-format indents nothing in a namespace, and ends a function by a brace in
    the first column."""
    begin, header, inside = 0, "", False
    for number, line in enumerate(text.split("\n")):
        line = re.sub(r"\s*//.*", "", line)
        if inside:
            if line.startswith("}"):
                called = re.search(r"([\w:~]+)\(", header)
                if called:
                    yield called.group(1), number + 1 - begin
                inside, header = False, ""
            continue
        if not header:
            begin = number
            if not re.match(r"[A-Za-z]", line):
                continue
        header += line
        if line.endswith("{") and not re.search(r"\b(namespace|struct|class|enum|union)\b[^(]*$", header):
            inside = True
        elif line.endswith(("{", ";", "}")) or not line:
            header = ""


def main():
    rooms = read_table()
    if not rooms:
        print("docs/ARCHITECTURE.md holds no table of rooms.")
        return 1
    order = {room: place for place, room in enumerate(rooms)}
    problems = []
    lines, files = collections.Counter(), collections.Counter()
    uses = collections.defaultdict(lambda: collections.defaultdict(list))
    folders, pairs = collections.defaultdict(set), collections.defaultdict(set)
    longest, longest_functions = [], []
    for path in sources():
        with open(os.path.join(ROOT, path), encoding="utf-8") as file:
            text = file.read()
        room = room_of(path, rooms)
        if room not in rooms and room not in OUTSIDE:
            problems.append(f"{path}: core/{room} is no room of the table in docs/ARCHITECTURE.md")
            continue
        lines[room] += text.count("\n")
        files[room] += 1
        longest.append((text.count("\n"), path))
        longest_functions += [(count, f"{path} {name}") for name, count in functions(text)]
        for included in INCLUDE.findall(text):
            if not os.path.exists(os.path.join(ROOT, included)) and not included.startswith("ui/shaders"):
                problems.append(f"{path}: there is no {included}")
            here, there = (re.sub(r"\.\w+$", "", name) for name in (path, included))
            if here != there:
                pairs[here].add(there)
                pairs[there]  # pylint: disable=pointless-statement
            if os.path.dirname(path) != os.path.dirname(included):
                folders[os.path.dirname(path)].add(os.path.dirname(included))
                folders[os.path.dirname(included)]  # pylint: disable=pointless-statement
            other = room_of(included, rooms)
            if other != room:
                uses[room][other].append(f"{path} includes {included}")

    for room, others in uses.items():
        for other, where in others.items():
            if room in OUTSIDE:
                if other in ("app", "cuda"):
                    problems.append(f"{where[0]}: nothing includes {other}")
            elif other in OUTSIDE:
                problems.append(f"{where[0]}: rooms of core include nothing of {other}")
            elif order.get(other, len(order)) >= order[room]:
                problems.append(f"{where[0]}: {other} stands above {room}")
            elif other not in rooms[room]:
                problems.append(f"{where[0]}: the table does not list {other} among what {room} uses")
    for room, listed in rooms.items():
        for other in sorted(listed - set(uses[room])):
            problems.append(f"docs/ARCHITECTURE.md: {room} uses nothing of {other}")
    for circle in circles(folders):
        problems.append("folders include each other: " + ", ".join(circle))
    among_sources = {tuple(circle) for circle in circles(pairs)}
    for circle in sorted(among_sources - set(ALLOWED_CIRCLES)):
        problems.append("sources include each other: " + ", ".join(circle))
    for circle in sorted(set(ALLOWED_CIRCLES) - among_sources):
        problems.append("ALLOWED_CIRCLES names sources that do not include each other: " + ", ".join(circle))
    for count, path in longest:
        if count > MOST_LINES:
            problems.append(f"{path} has {count} lines; {MOST_LINES} are the most")

    floor = {}
    for room in list(rooms) + ["cuda", "ui", "app"]:
        floor[room] = 1 + max((floor[other] for other in uses[room] if other in floor), default=-1)
    if "--quiet" not in sys.argv:
        print(f"{'room':12} {'floor':>5} {'files':>5} {'lines':>6}  uses")
        for room in list(rooms) + ["cuda", "ui", "app"]:
            print(f"{room:12} {floor[room]:5} {files[room]:5} {lines[room]:6}  {' '.join(sorted(uses[room]))}")
        print(f"{sum(lines.values())} lines in {sum(files.values())} files, {max(floor.values()) + 1} floors")
        print("Longest files: " + ", ".join(f"{path} {count}" for count, path in sorted(longest)[:-9:-1]))
        print("Longest functions: " + ", ".join(f"{where} {count}" for count, where in sorted(longest_functions)[:-9:-1]))
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())

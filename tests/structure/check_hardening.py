#!/usr/bin/env python3
"""Whether programs were linked and compiled as LIKENESS_HARDEN says: check_hardening.py PROGRAM..."""
import subprocess
import sys


def readelf(option, program):
    return subprocess.run(["readelf", "-W", option, program], check=True, capture_output=True, text=True).stdout


def faults(program):
    header, segments = readelf("-h", program), readelf("-l", program)
    dynamic, symbols = readelf("-d", program), readelf("--dyn-syms", program)
    wanted = {
        "is no position-independent program": "DYN (" in header,
        "has tables that stay writable (no GNU_RELRO)": "GNU_RELRO" in segments,
        "finds functions only when they are called (no BIND_NOW)": "BIND_NOW" in dynamic or "NOW" in dynamic,
        "has an executable stack": all(" RWE " not in line for line in segments.splitlines() if "GNU_STACK" in line),
        "checks no stack (no __stack_chk_fail)": "__stack_chk_fail" in symbols,
        "checks no buffer (no _chk function of the C library)":
            any("_chk@" in line and "stack_chk" not in line for line in symbols.splitlines()),
        "checks no bounds (no __glibcxx_assert_fail)": "__glibcxx_assert_fail" in symbols,
    }
    return [f"{program} {fault}" for fault, holds in wanted.items() if not holds]


found = [fault for program in sys.argv[1:] for fault in faults(program)]
for fault in found:
    print(fault)
sys.exit(1 if found or len(sys.argv) < 2 else 0)

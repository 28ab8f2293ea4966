#!/usr/bin/env bash
# Every source is as clang-format 14 writes it.
#   tests/structure/check_format.sh [CLANG_FORMAT]
set -euo pipefail
cd "$(dirname "$0")/../.."
find app core ui tests \( -name '*.h' -o -name '*.cpp' -o -name '*.cu' \) -print0 | sort -z \
  | xargs -0 -n 40 -P "$(nproc)" "${1:-clang-format}" --dry-run --Werror

# Sourced by packaging/run and packaging/test: installs what is missing, makes the networks, configures and builds.
# Needs: $root, the checkout. The package names of Debian 12 and 13; other systems get the list to install by hand.

# package:why
packages=(
  "build-essential:the compiler"
  "cmake:the build"
  "ninja-build:the build"
  "pkg-config:finding libraries"
  "libeigen3-dev:small matrices"
  "libtbb-dev:parallel loops"
  "libfmt-dev:text formatting"
  "nlohmann-json3-dev:project files"
  "libcli11-dev:the command line"
  "libxxhash-dev:content hashes"
  "zlib1g-dev:head model archives"
  "libwebp-dev:checking pictures before they are opened"
  "libsqlite3-dev:COLMAP's database"
  "libopencv-dev:feature tracks and mattes"
  "libopenimageio-dev:pictures in and out"
  "openimageio-tools:needed by OpenImageIO's CMake files"
  "libavcodec-dev:video"
  "libavformat-dev:video"
  "libavutil-dev:video"
  "libswscale-dev:video"
  "libceres-dev:fitting the head"
  "libembree-dev:rays against meshes"
  "libdlib-dev:finding faces"
  "libhwy-dev:SIMD kernels"
  "colmap:cameras of moving clips"
  "libvtk9-dev:3-D views and charts of the studio"
  "libglfw3-dev:the studio's window"
  "libimgui-dev:the studio's panels"
  "libstb-dev:letters of the panels"
  "libfontconfig-dev:letters of the system's fonts"
  "libfreetype-dev:letters of the system's fonts"
  "libgl-dev:drawing the window"
  "libopengl-dev:drawing the window"
  "fonts-inter:the studio's letters"
)
test_packages=(
  "libgtest-dev:the tests"
  "libgmock-dev:the tests"
  "libdlib-data:the landmark model, with which the face network is compared"
  "ffmpeg:making odd video files for the tests, and reading exported ones"
  "python3-vtk9:reading exported meshes"
  "python3:checking the structure"
  "clang-format:checking the format"
  "xvfb:a display for the window's tests"
  "xauth:needed by xvfb-run"
  "xdotool:real clicks on the window"
  "man-db:reading the manual pages"
  "desktop-file-utils:checking the desktop entry"
  "libgl1-mesa-dri:drawing the window without a graphics card"
  "patchelf:the bundle, and what it asks for"
)
# What the tests of unlucky machines need besides.
stress_packages=(
  "strace:calls that fail, and kills at a call"
)
bundle_packages=(
  "patchelf:libraries found by where they lie"
  "binutils:reading what libraries ask for"
  "xz-utils:packing"
)
# Packages of which something is compiled into the programs: packaging/copyright names them too.
compiled_in=(libimgui-dev libstb-dev libcli11-dev nlohmann-json3-dev libeigen3-dev libhwy-dev libdlib-dev libceres-dev)

say() { printf '%s\n' "$*"; }

install_missing() {
  local entry name missing=()
  for entry in "$@"; do
    name=${entry%%:*}
    dpkg-query -W -f '${Status}' "$name" 2>/dev/null | grep -q 'install ok installed' || missing+=("$entry")
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  say "Likeness needs packages that are not installed:"
  for entry in "${missing[@]}"; do say "  ${entry%%:*} (${entry#*:})"; done
  if ! command -v apt-get >/dev/null; then
    say "This system has no apt-get: install their equivalents where they are absent."
    say "Going on; CMake names what it does not find."
    return 0
  fi
  local sudo=()
  if [ "$(id -u)" -ne 0 ]; then
    sudo=(sudo)
    say "Installing them with sudo; you may be asked for your password."
  fi
  "${sudo[@]}" apt-get update -qq
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]%%:*}"
}

# The networks for person and face, where they can be had: whatever comes of it, all else goes on. Nothing is fetched
# where LIKENESS_NETWORKS says that they lie elsewhere.
make_networks() {
  [ -n "${LIKENESS_NETWORKS:-}" ] || "$root/packaging/networks" ||
    say "Going on without them; packaging/networks makes them later." >&2
}

# dlib's landmark model, which the face network makes needless: its training data are for research. It is installed
# where the network could not be had, or where LIKENESS_DLIB=yes asks for it.
wants_landmark_model() {
  [ "${LIKENESS_DLIB:-}" = yes ] || [ ! -f "${LIKENESS_NETWORKS:-$root/build/networks}/face468.onnx" ]
}
install_landmark_model() {
  ! wants_landmark_model || install_missing "libdlib-data:the landmark model, instead of the face network"
}

# configure_and_build PRESET [cmake options]: a compiler cache is used where there is one. build_target: one target
# instead of all; build_folder: another folder than the preset's.
configure_and_build() {
  local preset=$1
  shift
  local launcher=()
  if command -v ccache >/dev/null; then
    launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
    # Precompiled headers are cached only where their macros of time may be taken as they were, and shared between
    # build folders only where paths are seen from these.
    export CCACHE_NOHASHDIR=1 CCACHE_BASEDIR=$root CCACHE_SLOPPINESS=pch_defines,time_macros
  fi
  local folder=${build_folder:-$root/build/$preset}
  # A folder's sources compiled together take up to 3 GB.
  local jobs
  jobs=$(awk -v most="$(($(nproc) + 1))" '/^MemAvailable/ { room = int($2 / 3e6); print room < 1 ? 1 : room < most ? room : most }' /proc/meminfo)
  (cd "$root" && cmake --preset "$preset" -B "$folder" "${launcher[@]}" "$@" &&
    cmake --build "$folder" --parallel "${jobs:-1}" ${build_target:+--target "$build_target"})
}

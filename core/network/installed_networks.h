// The small networks that packaging/networks makes and that come with an installed Likeness. Everything works
// without them, though not as well: who wants one asks here, and is told why it is missing.
//
// They are MediaPipe's (Google, Apache-2.0), converted to ONNX with their numbers unchanged. Pictures are
// RGB, tensors (1, 3, side, side); points are in pixels of the input, x to the right, y down, from its left
// upper corner.
//
// person, 256 px, 0..1: "activation_10" (1, 1, 256, 256), the share of person, 0..1. The picture is squashed
// into the square; of a crop, no part lies outside the picture.
//
// face468, 192 px, 0..1: "conv2d_21" (1, 1404, 1, 1), 468 points x, y, z; z is in the scale of x, relative to
// the middle of the head, smaller nearer to the camera. "conv2d_31" (1, 1, 1, 1), the logit of a face being
// there. The crop is 1.5 times the box of the points, with the eyes level.
//
// iris, 64 px, 0..1, the person's left eye as it is or the right one mirrored:
// "output_eyes_contours_and_brows" (1, 213), 71 points x, y, z, and "output_iris" (1, 15), 5 points x, y, z:
// the centre, then the circle's right, top, left and bottom in the picture.
//
// face_detector, 128 px, -1..1: "regressors" (1, 896, 16), for each anchor a box - centre x, y, width,
// height - and six points, relative to the anchor, and "classificators" (1, 896, 1), the logit of a face.
// Anchors lie at the centres of 16 x 16 cells, two each, then of 8 x 8, six each, row by row.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/network/onnx_network.h"

namespace likeness {

enum class InstalledNetwork { person, face468, iris, face_detector };

// What is known of a network before it is looked for.
struct InstalledNetworkFile {
  InstalledNetwork network;
  const char* file;    // its name in the networks' folder
  int side;            // of the square picture it is given, pixels
  const char* what;    // what it finds
  const char* sha256;  // of the one file that is accepted; packaging/networks has the same
};
std::span<const InstalledNetworkFile> installed_network_files();  // in the order of the enumeration
const InstalledNetworkFile& installed_network_file(InstalledNetwork network);

// Where networks lie: in the folder that the environment variable LIKENESS_NETWORKS names, and in no other,
// if it is set and not empty; else in the program's PREFIX/share/likeness/networks; else, for a program in a
// build folder of the checkout (build/PRESET/bin), in build/networks.
//
// The file of a network, its content unseen. missing_dependency: there is none; `what` names the places that
// were looked at and `fix` what to do.
Result<std::filesystem::path> find_installed_network(InstalledNetwork network);

// The file, read, held against its hash, and loaded; a few milliseconds. missing_dependency as above;
// bad_input: it is another file than the pinned one, or damaged. Each call loads afresh: keep what it
// returns. max_concurrent: as of OnnxNetwork::load.
Result<OnnxNetwork> load_installed_network(InstalledNetwork network, int max_concurrent = 1);

// One hash of the file (core/base/hash.h) for results that depend on it, "absent" where there is none: a
// stage's result becomes stale when the network comes or goes.
std::string installed_network_hash(InstalledNetwork network);

}  // namespace likeness

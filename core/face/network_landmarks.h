// The 68 landmarks from the network's 468 points (face_network.h): where iBUG's drawing has them and a head
// model's own landmarks are, so that a fit does not ask which source they come from. Used by FaceDetector.
#pragma once

#include <array>
#include <vector>

#include "core/face/face_landmarks.h"
#include "core/face/face_network.h"

namespace likeness {

inline constexpr int kNetworkLandmarksVersion = 1;  // raised when the same networks give other landmarks

std::array<Vec2d, kLandmarkCount> ibug_points(const std::array<Vec2d, kMeshCount>& mesh);

// The network draws shut lips 0.01 to 0.03 distances of the eyes' outer corners apart, open ones from 0.04 on
// (marked frames of seven clips): inner lips that near are drawn together, each pair about its middle.
void close_shut_lips(std::array<Vec2d, kLandmarkCount>& points);

// The box that dlib's detector draws about a face with these landmarks: from above the brows to the chin.
FaceBox box_round(const std::array<Vec2d, kLandmarkCount>& points);
// The network's region for a face in such a box.
MeshRegion region_of(const FaceBox& box, double roll = 0);

// As FaceDetector::detect. Scores are 2 presence - 1.
std::vector<FaceBox> network_faces(const FaceNetwork& network, const Image8& picture, const FaceBox* before);
// As FaceDetector::landmarks. Further looks, of which every second is at the mirrored picture, are averaged;
// the spread is the network's usual error on faces of this size, with how much the looks differ.
Landmarks network_landmarks(const FaceNetwork& network, const Image8& picture, const FaceBox& box,
                            const LandmarkHint* hint, const LandmarkEffort& effort);

}  // namespace likeness

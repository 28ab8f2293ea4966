// Frusta, their path and the head as VTK meshes: see camera_scene.h.
#include "ui/camera_scene.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/rigid.h"
#include "core/head/pose_head.h"
#include "ui/theme.h"
#include "ui/vtk_view.h"

namespace likeness::ui {

namespace {

constexpr std::size_t kFrusta = 60;       // drawn at most
constexpr double kFarthestPoint = 6;      // m from the head; points farther off say nothing about the path
constexpr double kFrustumDepth = 0.06;    // m
constexpr double kFill = 0.92;            // of the view, filled by what is looked at
constexpr double kFieldOfFrustum = 0.35;  // largest half width of a drawn frustum, per unit of depth

// Points, lines or triangles of one colour.
struct Layer {
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkActor> actor;
};

void clear_layer(Layer& layer) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> none;
  layer.data->SetPoints(points);
  layer.data->SetLines(none);
  layer.data->SetPolys(none);
  layer.data->SetVerts(none);
}

void set_lines(Layer& layer, const std::vector<Vec3d>& vertices, const std::vector<std::vector<int>>& lines) {
  vtkNew<vtkPoints> points;
  for (const Vec3d& v : vertices) points->InsertNextPoint(v.x(), v.y(), v.z());
  vtkNew<vtkCellArray> cells;
  for (const auto& line : lines) {
    cells->InsertNextCell(int(line.size()));
    for (const int i : line) cells->InsertCellPoint(i);
  }
  layer.data->SetPoints(points);
  layer.data->SetLines(cells);
}

void set_points(Layer& layer, const std::vector<Vec3d>& places) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> cells;
  for (const Vec3d& v : places) {
    const vtkIdType id = points->InsertNextPoint(v.x(), v.y(), v.z());
    cells->InsertNextCell(1, &id);
  }
  layer.data->SetPoints(points);
  layer.data->SetVerts(cells);
}

// The room's points about the head as it was in the first frame that found it.
std::vector<Vec3d> room_about_head(const ProjectContents& contents) {
  std::vector<Vec3d> places;
  const auto& frames = contents.track->frames;
  const auto first =
      std::ranges::find_if(frames, [](const TrackedFrame& f) { return f.status != FrameStatus::lost; });
  if (first == frames.end()) return places;
  const Pose head_from_world = inverse(first->pose.world_from_head);
  for (const Vec3f& point : *contents.points) {
    const Vec3d place = head_from_world * point.cast<double>();
    if (place.norm() < kFarthestPoint) places.push_back(place);
  }
  return places;
}

// Frames to draw cameras of: those whose head was found, evenly thinned.
std::vector<const TrackedFrame*> chosen_frames(const Track& track) {
  std::vector<const TrackedFrame*> found;
  for (const TrackedFrame& frame : track.frames)
    if (frame.status != FrameStatus::lost) found.push_back(&frame);
  std::vector<const TrackedFrame*> chosen;
  const std::size_t count = std::min(found.size(), kFrusta);
  for (std::size_t i = 0; i < count; ++i)
    chosen.push_back(found[count > 1 ? i * (found.size() - 1) / (count - 1) : 0]);
  return chosen;
}

// Lines of frusta, and of the path of their apices.
struct Frusta {
  std::vector<Vec3d> corners, eyes;
  std::vector<std::vector<int>> outlines, path{1};

  void add(const Pose& scene_from_cam, const Intrinsics& k) {
    const double w = std::min(kFieldOfFrustum, 0.5 * k.width / k.fx) * kFrustumDepth,
                 h = w * double(k.height) / double(std::max(1, k.width));
    const int first = int(corners.size());
    corners.push_back(scene_from_cam.translation());
    for (const auto& [x, y] : {std::pair{-w, -h}, {w, -h}, {w, h}, {-w, h}})
      corners.push_back(scene_from_cam * Vec3d(x, y, kFrustumDepth));
    for (int c = 1; c <= 4; ++c) outlines.push_back({first, first + c});
    outlines.push_back({first + 1, first + 2, first + 3, first + 4, first + 1});
    path[0].push_back(int(eyes.size()));
    eyes.push_back(scene_from_cam.translation());
  }
};

}  // namespace

struct CameraScene::Impl {
  VtkView view{VtkView::Hand::orbit};
  Layer frusta, path, head, points;
  std::vector<Vec3d> looked_at;  // corners of head and cameras
  bool to_fit = false;           // show all of it as soon as the view's shape is known
  vtkNew<vtkPolyDataNormals> normals;
  std::shared_ptr<const ProjectContents> contents;  // what is shown: these
  std::shared_ptr<const SolvingCameras> solving;    // or these
  bool dark = false;
  float scale = 0;

  // From the side and above, where an arc in front of the face is seen best; as near as still shows all of
  // it.
  void fit(double aspect) {
    const Vec3d back = Vec3d(1.0, 0.7, 0.75).normalized(), right = Vec3d::UnitY().cross(back).normalized(),
                up = back.cross(right);
    vtkCamera* camera = view.renderer()->GetActiveCamera();
    const double half = 0.5 * camera->GetViewAngle() * std::numbers::pi / 180, high = kFill * std::tan(half),
                 wide = high * aspect;
    // The eye (x, y, z along right, up, back) stands so that no corner is beyond a plane of its frustum.
    double east = -1e9, west = -1e9, north = -1e9, south = -1e9, near = -1e9, far = 1e9;
    for (const Vec3d& corner : looked_at) {
      const double x = corner.dot(right), y = corner.dot(up), z = corner.dot(back);
      east = std::max(east, x + wide * z), west = std::max(west, -x + wide * z);
      north = std::max(north, y + high * z), south = std::max(south, -y + high * z);
      near = std::max(near, z), far = std::min(far, z);
    }
    const double z = std::max((east + west) / (2 * wide), (north + south) / (2 * high));
    const Vec3d on_axis = 0.5 * (east - west) * right + 0.5 * (north - south) * up, eye = on_axis + z * back,
                focus = on_axis + 0.5 * (near + far) * back;
    camera->SetFocalPoint(focus.x(), focus.y(), focus.z());
    camera->SetPosition(eye.x(), eye.y(), eye.z());
    camera->SetViewUp(0, 1, 0);
    view.touch();
  }
  void clear() {
    for (Layer* layer : {&frusta, &path, &head, &points}) clear_layer(*layer);
    view.touch();
  }
  // low, high: bounding box of what else is looked at.
  void show(const Frusta& lines, Vec3d low, Vec3d high) {
    set_lines(frusta, lines.corners, lines.outlines);
    if (lines.eyes.size() > 1) set_lines(path, lines.eyes, lines.path);
    looked_at = lines.corners;
    for (int corner = 0; corner < 8; ++corner)
      looked_at.emplace_back((corner & 1 ? high : low).x(), (corner & 2 ? high : low).y(),
                             (corner & 4 ? high : low).z());
  }
};

CameraScene::CameraScene() : impl_(std::make_unique<Impl>()) {
  Impl& my = *impl_;
  for (Layer* layer : {&my.frusta, &my.path, &my.head, &my.points}) {
    clear_layer(*layer);
    if (layer == &my.head) {
      my.normals->SetInputData(layer->data);
      my.normals->SplittingOff();
      layer->mapper->SetInputConnection(my.normals->GetOutputPort());
    } else {
      layer->mapper->SetInputData(layer->data);
      layer->actor->GetProperty()->LightingOff();
    }
    layer->actor->SetMapper(layer->mapper);
    my.view.renderer()->AddActor(layer->actor);
  }
}

CameraScene::~CameraScene() = default;

// The head rests in the middle and the cameras move round it: everything is drawn in the head's frame, so
// that a turning head before a resting camera, too, shows how much of it was seen.
void CameraScene::set(std::shared_ptr<const ProjectContents> contents) {
  Impl& my = *impl_;
  if (contents == my.contents && !my.solving) return;
  my.contents = std::move(contents);
  my.solving.reset();
  my.clear();
  if (!my.contents || !my.contents->track || !my.contents->cameras || !my.contents->model) return;
  const Track& track = *my.contents->track;
  const CameraSet& cameras = *my.contents->cameras;
  const HeadModel& model = *my.contents->model;
  if (track.person.identity.size() != model.identity_count()) return;

  const HeadShape shape = shape_head(model, track.person);
  Articulation rest = neutral_articulation(model);
  if (track.neutral.expression.size() == model.expression_count()) rest = track.neutral;
  const std::vector<Vec3f> posed = pose_head(model, shape, rest);
  vtkNew<vtkPoints> points;
  Vec3d low = Vec3d::Constant(1e9), high = -low;
  for (const Vec3f& v : posed) {
    points->InsertNextPoint(v.x(), v.y(), v.z());
    low = low.cwiseMin(v.cast<double>()), high = high.cwiseMax(v.cast<double>());
  }
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& t : model.triangles) {
    triangles->InsertNextCell(3);
    for (int c = 0; c < 3; ++c) triangles->InsertCellPoint(t[c]);
  }
  my.head.data->SetPoints(points);
  my.head.data->SetPolys(triangles);

  Frusta frusta;
  for (const TrackedFrame* frame : chosen_frames(track)) {
    const Camera* camera = find_camera(cameras, frame->frame);
    if (!camera) continue;
    Pose cam_from_world = camera->cam_from_world;
    cam_from_world.translation() *= track.metres_per_unit;
    frusta.add(inverse(cam_from_world * frame->pose.world_from_head), camera->intrinsics);
  }
  my.show(frusta, low, high);
  if (my.contents->points) set_points(my.points, room_about_head(*my.contents));
  look_at_all();
}

void CameraScene::set(std::shared_ptr<const SolvingCameras> solving) {
  Impl& my = *impl_;
  if (solving == my.solving) return;
  const bool first = !my.solving;
  my.contents.reset();
  my.solving = std::move(solving);
  my.clear();
  if (!my.solving) return;
  const auto& cameras = my.solving->cameras;
  Frusta frusta;
  const std::size_t count = std::min(cameras.size(), kFrusta);
  for (std::size_t i = 0; i < count; ++i) {
    const auto& camera = cameras[count > 1 ? i * (cameras.size() - 1) / (count - 1) : 0];
    frusta.add(camera.world_from_cam, camera.intrinsics);
  }
  my.show(frusta, Vec3d::Constant(-0.8 * my.solving->reach), Vec3d::Constant(0.8 * my.solving->reach));
  set_points(my.points, my.solving->points);
  if (first) look_at_all();  // afterwards as the user has turned it
}

void CameraScene::look_at_all() { impl_->to_fit = true; }

void CameraScene::draw(const char* name, ImVec2 size) {
  Impl& my = *impl_;
  const Theme& t = theme();
  if (my.dark != t.dark || my.scale != t.scale) {
    my.dark = t.dark, my.scale = t.scale;
    const Palette& p = t.colours;
    my.view.renderer()->SetBackground(p.panel.x, p.panel.y, p.panel.z);
    my.frusta.actor->GetProperty()->SetColor(p.accent.x, p.accent.y, p.accent.z);
    my.frusta.actor->GetProperty()->SetLineWidth(1.2f * t.scale);
    my.path.actor->GetProperty()->SetColor(p.warn.x, p.warn.y, p.warn.z);
    my.path.actor->GetProperty()->SetLineWidth(2.2f * t.scale);
    my.points.actor->GetProperty()->SetColor(p.faint.x, p.faint.y, p.faint.z);
    my.points.actor->GetProperty()->SetPointSize(2.5f * t.scale);
    my.head.actor->GetProperty()->SetColor(0.78, 0.72, 0.68);
    my.head.actor->GetProperty()->SetSpecular(0.15);
    my.view.touch();
  }
  if (my.to_fit && !my.looked_at.empty() && size.x >= 1 && size.y >= 1) {
    my.to_fit = false;
    my.fit(double(size.x) / double(size.y));
  }
  my.view.renderer()->ResetCameraClippingRange();
  my.view.draw(name, size);
}

}  // namespace likeness::ui

// Pictures on a device: see FrameRenderer in backend.h. The avatar's fields and grids are on the device. A
// frame's work is recorded once per picture size and replayed: its pose is copied in, one replay, the picture
// is copied out, and the host waits only for that. A picture is cut into bands of tiles, so that the largest
// possible batch fits.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <optional>

#include "core/base/check.h"
#include "core/field/device_field.h"
#include "core/render/backend.h"
#include "core/render/device_frame.h"
#include "core/render/device_picture.h"
#include "core/render/pixel_bands.h"

namespace likeness {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{3}
                                  << 30;  // for the bands' buffers, and at most a quarter of what is free
constexpr std::size_t kLanes = 16384;     // rays whose stretches are kept at once where no strata need them

template <class T>
Result<void> make(const std::shared_ptr<Device>& device, DeviceArray<T>& array, std::size_t count) {
  auto made = DeviceArray<T>::make(device, std::max<std::size_t>(1, count));
  if (!made) return made.error();
  array = std::move(*made);
  return {};
}

// The host's copy must stay until the device has been waited for.
template <class T>
Result<void> upload(const std::shared_ptr<Device>& device, DeviceArray<T>& array, std::span<const T> from) {
  if (auto done = make(device, array, from.size()); !done) return done;
  return device->copy_in(array.data(), from.data(), from.size_bytes());
}

// A field and its grids on the device.
struct DevicePart {
  const FieldPart* part = nullptr;  // null: there is none
  MarchVolume volume;
  DeviceArray<std::uint8_t> bits, core, opacity, bricks;
  std::unique_ptr<DeviceField> field;

  MarchGrid grid() const {
    if (!part) return {};
    const OccupancyGrid& own = part->occupancy;
    const auto& origin = part->cube.origin;
    MarchGrid grid{1, own.resolution, {origin.x(), origin.y(), origin.z()}, part->cube.side, {}, {}, {}, {}};
    if (own.resolution == 0) return grid;
    grid.bits = bits.data(), grid.bricks = bricks.data();
    if (part->core.resolution == own.resolution) grid.core = core.data();
    if (!part->opacity.empty()) grid.opacity = opacity.data();
    return grid;
  }
  // Stretches that a ray can have at most.
  std::size_t rows() const { return part ? std::size_t(std::max(1, 3 * part->occupancy.resolution)) : 0; }
};

// Samples of rays, and where they lie in the fields' batches.
struct RayMemory {
  DeviceArray<float> t, dt;
  DeviceArray<std::uint32_t> count, offset;

  Result<void> allocate(const std::shared_ptr<Device>& device, std::size_t rays, std::size_t most) {
    for (DeviceArray<float>* array : {&t, &dt})
      if (auto done = make(device, *array, rays * most); !done) return done;
    for (DeviceArray<std::uint32_t>* array : {&count, &offset})
      if (auto done = make(device, *array, 2 * rays); !done) return done;
    return {};
  }
  PlacedRays of(std::size_t rays, int most) const {
    return {t.data(), dt.data(), count.data(), std::uint32_t(rays), most};
  }
};

struct PictureSums {
  std::uint32_t samples, met, ignored, no_field;
};

// Buffers and recording for one picture size and one set of options.
struct Picture {
  Intrinsics intrinsics;
  RenderOptions options;
  PictureTiles tiles;
  DeviceArray<float> directions, block_directions, rgba;
  DeviceArray<std::uint32_t> place, block;
  DeviceArray<BlockPlace> block_place;
  RayMemory strata, refined, pixels;
  DeviceArray<float> near, far, depth, weights;
  DeviceArray<std::uint32_t> list_count;
  DeviceArray<std::uint32_t> alone, alone_count;
  DeviceArray<PictureSums> sums;
  std::size_t lanes = 0;
};

class DeviceRenderer : public FrameRenderer {
 public:
  DeviceRenderer(std::shared_ptr<Device> device, const Avatar& avatar, bool halves)
      : device_(std::move(device)), avatar_(avatar), halves_(halves) {
    parts_[0].part = &avatar.head;
    if (avatar.torso) parts_[1].part = &*avatar.torso;
  }
  ~DeviceRenderer() override { forget(); }

  Result<void> prepare() {
    const std::array<float, 256>& depths = depth_of_opacity();
    if (auto done = upload(device_, depths_, std::span<const float>(depths)); !done) return done;
    for (DevicePart& part : parts_) {
      if (!part.part) continue;
      const FieldPart& own = *part.part;
      part.volume = march_volume(own.occupancy, own.core, own.cube.side, own.opacity);
      const auto send = [&](DeviceArray<std::uint8_t>& to, const std::vector<std::uint8_t>& from) {
        return upload(device_, to, std::span<const std::uint8_t>(from));
      };
      if (auto done = send(part.bits, own.occupancy.bits); !done) return done;
      if (auto done = send(part.core, own.core.bits); !done) return done;
      if (auto done = send(part.opacity, own.opacity); !done) return done;
      if (auto done = send(part.bricks, part.volume.bricks); !done) return done;
    }
    const auto n = std::size_t(avatar_.neck.empty() ? 0 : avatar_.head.occupancy.resolution);
    if (auto done = make(device_, neck_cells_, 2 * n * n * n); !done) return done;
    return device_->wait();
  }

  Result<RenderedFrame> render(const Camera& camera, const RenderState& state,
                               const RenderOptions& options) override {
    LIKENESS_CHECK(avatar_.warp_cell == 0 || !state.warp.empty(),
                   "an avatar with a warp needs pose_avatar's state (cell %g m)", double(avatar_.warp_cell));
    auto frame = render_on_device(camera, state, device_options(options));
    if (frame) return frame;
    Error error = frame.error();
    if (error.where.starts_with("CUDA"))
      error.where = "CUDA, rendering",
      error.fix = "Close other programs that use the GPU, or use --backend cpu.";
    return error;
  }
  std::string backend() const override { return "cuda"; }

 private:
  Result<RenderedFrame> render_on_device(const Camera& camera, const RenderState& state,
                                         const RenderOptions& options) {
    if (auto done = fit_picture(camera.intrinsics, options); !done) return done.error();
    pack_frame(avatar_, camera, state, parts_[0].volume, packed_);
    if (auto done = fit_frame(); !done) return done.error();
    if (!recording_)
      if (auto done = record(); !done) return done.error();
    if (auto done = device_->copy_in(frame_.data(), packed_.data(), packed_.size()); !done)
      return done.error();
    const Eigen::VectorXf psi = condition(avatar_.condition, state.pose.articulation);
    if (psi.size() > 0)
      if (auto done = parts_[0].field->set_conditions(psi.data(), 1); !done) return done.error();
    if (auto done = device_->replay(recording_); !done) return done.error();
    RenderedFrame out;
    out.rgba = Image(camera.intrinsics.width, camera.intrinsics.height, 4);
    PictureSums sums{};
    if (auto done = device_->copy_out(out.rgba.data.data(), picture_->rgba.data(),
                                      out.rgba.data.size() * sizeof(float));
        !done)
      return done.error();
    if (auto done = device_->copy_out(&sums, picture_->sums.data(), sizeof(sums)); !done) return done.error();
    if (auto done = device_->wait(); !done) return done.error();
    out.samples_per_ray = sums.met > 0 ? double(sums.samples) / double(sums.met) : 0;
    return out;
  }

  void forget() {
    if (recording_) device_->forget(recording_);
    recording_ = nullptr;
  }

  // -- Buffers

  // Device memory for bands of this many tiles.
  std::size_t bytes_of(const RenderOptions& options, std::size_t tiles) const {
    const BandShape shape = band_shape(options, tiles);
    std::size_t bytes = shape.lanes * (parts_[0].rows() + parts_[1].rows()) * 3 * sizeof(float);
    bytes += 8 * (shape.blocks * std::size_t(options.strata + options.max_samples) +
                  shape.pixels * std::size_t(options.max_samples));
    bytes += 4 * shape.pixels;  // those left alone
    for (const DevicePart& part : parts_)
      if (part.part)
        bytes += device_field_bytes(part.part->field.config, field_options(options, shape), device_->facts());
    return bytes;
  }
  struct BandShape {
    std::size_t pixels, blocks, lanes, samples;
  };
  static BandShape band_shape(const RenderOptions& options, std::size_t tiles) {
    const auto side = std::size_t((kTileSide + options.block - 1) / options.block);
    BandShape shape{tiles * kTileSide * kTileSide, tiles * side * side, 0, 0};
    shape.lanes = options.strata > 0 ? shape.blocks : std::min(shape.pixels, kLanes);
    shape.samples =
        std::max(shape.pixels * std::size_t(options.max_samples), shape.blocks * std::size_t(options.strata));
    return shape;
  }
  DeviceFieldOptions field_options(const RenderOptions& options, const BandShape& shape) const {
    const bool halves = halves_ && options.precision == FieldPrecision::bf16;
    return {shape.samples, 1, false, halves ? NetworkPrecision::bf16 : NetworkPrecision::single};
  }

  Result<void> fit_picture(const Intrinsics& intrinsics, const RenderOptions& options) {
    if (picture_ && same_picture(picture_->intrinsics, intrinsics) &&
        same_options(picture_->options, options))
      return {};
    LIKENESS_CHECK(options.max_samples > 0 && options.strata >= 0 && options.block > 0,
                   "max_samples %d, strata %d, block %d", options.max_samples, options.strata, options.block);
    forget();
    picture_.reset();
    for (DevicePart& part : parts_) part.field.reset();
    Picture made;
    made.intrinsics = intrinsics, made.options = options;
    const std::size_t most = std::min(kMaxBytes, std::size_t(device_->facts().free_bytes / 4));
    std::size_t tiles = tile_count(intrinsics);
    while (tiles > 1 && bytes_of(options, tiles) > most) tiles = (tiles + 1) / 2;
    const BandShape shape = band_shape(options, tiles);
    made.tiles = picture_tiles(intrinsics, options.block, tiles);
    if (auto done = allocate(made, shape); !done) return done;
    for (DevicePart& part : parts_) {
      if (!part.part) continue;
      auto field = DeviceField::make(device_, part.part->field.config, field_options(options, shape));
      if (!field) return field.error();
      part.field = std::move(*field);
      if (auto done = part.field->place(part.part->field, nullptr); !done) return done;
    }
    if (auto done = device_->wait(); !done) return done;
    picture_ = std::move(made);
    return {};
  }

  Result<void> allocate(Picture& p, const BandShape& shape) {
    const PictureTiles& tiles = p.tiles;
    if (auto done = upload(device_, p.directions, std::span<const float>(tiles.directions)); !done)
      return done;
    if (auto done = upload(device_, p.place, std::span<const std::uint32_t>(tiles.place)); !done) return done;
    if (auto done = upload(device_, p.block, std::span<const std::uint32_t>(tiles.block)); !done) return done;
    if (auto done = upload(device_, p.block_directions, std::span<const float>(tiles.block_directions));
        !done)
      return done;
    if (auto done = upload(device_, p.block_place, std::span<const BlockPlace>(tiles.block_place)); !done)
      return done;
    const auto most = std::size_t(p.options.max_samples), strata = std::size_t(p.options.strata);
    if (auto done = p.pixels.allocate(device_, shape.pixels, most); !done) return done;
    if (strata > 0) {
      if (auto done = p.strata.allocate(device_, shape.blocks, strata); !done) return done;
      if (auto done = p.refined.allocate(device_, shape.blocks, most); !done) return done;
      if (auto done = make(device_, p.weights, shape.blocks * strata); !done) return done;
      if (auto done = make(device_, p.alone, shape.pixels); !done) return done;
      if (auto done = make(device_, p.alone_count, 1); !done) return done;
    }
    p.lanes = shape.lanes;
    const std::size_t rows = parts_[0].rows() + parts_[1].rows();
    for (DeviceArray<float>* array : {&p.near, &p.far, &p.depth})
      if (auto done = make(device_, *array, rows * p.lanes); !done) return done;
    if (auto done = make(device_, p.list_count, 2 * p.lanes); !done) return done;
    if (auto done = make(device_, p.rgba, 4 * tiles.place.size()); !done) return done;
    return make(device_, p.sums, 1);
  }

  // The frame's tables, with room to grow.
  Result<void> fit_frame() {
    if (frame_.size() >= packed_.size()) return {};
    forget();
    frame_ = {};
    return make(device_, frame_, packed_.size() + packed_.size() / 2);
  }

  // -- The recording

  Result<void> record() {
    if (auto done = device_->record(); !done) return done;
    const Result<void> queued = queue_frame();
    auto made = device_->end_record();  // whatever happened, recording ends
    if (!queued) return queued;
    if (!made) return made.error();
    recording_ = *made;
    return {};
  }

  MarchScene scene() const {
    const MarchVolumes usual;
    return {{parts_[0].grid(), parts_[1].grid()},
            depths_.data(),
            reinterpret_cast<const FrameNumbers*>(frame_.data()),
            neck_cells_.data(),
            usual.near,
            usual.far,
            picture_->options.min_step};
  }
  ListMemory lists(std::size_t lanes) const {
    const Picture& p = *picture_;
    return {p.near.data(),       p.far.data(),         p.depth.data(),
            p.list_count.data(), std::uint32_t(lanes), std::int32_t(parts_[0].rows())};
  }
  FieldAnswer answer(int f) const {
    const DevicePart& part = parts_[std::size_t(f)];
    if (!part.field) return {};
    return {part.field->sigma(), part.field->colours(), std::uint32_t(part.field->capacity()),
            part.part->cube.side};
  }

  Result<void> queue_frame() {
    const Picture& p = *picture_;
    if (auto done = device_->clear(p.sums.data(), sizeof(PictureSums)); !done) return done;
    if (!avatar_.neck.empty()) {
      const NeckCellsArgs args{scene(), neck_cells_.data()};
      if (auto done = device_->launch(Kernel::neck_cells, args, neck_cells_.size() / 2); !done) return done;
    }
    for (const PictureBand& band : p.tiles.bands) {
      if (auto done = p.options.strata > 0 ? queue_strata(band) : queue_march(band, false); !done)
        return done;
      if (auto done = queue_pixels(band); !done) return done;
    }
    return {};
  }

  // Places samples by the grids alone: for all pixels of a band, or those that their blocks left out.
  Result<void> queue_march(const PictureBand& band, bool alone) {
    const Picture& p = *picture_;
    const std::size_t lanes = std::min(p.lanes, band.pixels);
    const MarchRaysArgs args{scene(),
                             lists(lanes),
                             p.directions.data() + 3 * band.first_pixel,
                             alone ? p.alone.data() : nullptr,
                             p.alone_count.data(),
                             p.pixels.of(band.pixels, p.options.max_samples)};
    return device_->launch(Kernel::march_rays, args, lanes);
  }

  // Packs samples of rays into the fields' batches and maps them to canonical space.
  Result<void> queue_gather(const RayMemory& memory, const PlacedRays& rays, const float* directions,
                            bool of_pixels) {
    PictureSums* const sums = picture_->sums.data();
    RayOffsetsArgs offsets{
        rays, memory.offset.data(), {}, &sums->samples, of_pixels ? &sums->met : &sums->ignored};
    GatherArgs gather{scene(), rays, memory.offset.data(), directions, {}};
    for (std::size_t f = 0; f < 2; ++f) {
      const DeviceField* field = parts_[f].field.get();
      offsets.total[f] = field ? field->count() : &sums->no_field;
      if (auto done = device_->clear(offsets.total[f], sizeof(std::uint32_t)); !done) return done;
      for (int k = 0; k < 6 && field; ++k) gather.point[f][k] = field->point(k);
    }
    if (auto done = device_->launch(Kernel::ray_offsets, offsets, rays.rays); !done) return done;
    const std::size_t most = std::size_t(rays.rays) * std::size_t(rays.most);
    if (auto done = device_->launch(Kernel::gather_samples, gather, most); !done) return done;
    for (const DevicePart& part : parts_)
      if (part.field)
        if (auto done = part.field->density(most); !done) return done;
    return {};
  }

  // Places the samples of a band's pixels by what the rays of their blocks find.
  Result<void> queue_strata(const PictureBand& band) {
    const Picture& p = *picture_;
    const PlacedRays strata = p.strata.of(band.blocks, p.options.strata);
    const PlacedRays refined = p.refined.of(band.blocks, p.options.max_samples);
    const float* directions = p.block_directions.data() + 3 * band.first_block;
    const MarchStrataArgs march{scene(), lists(band.blocks), directions, strata};
    if (auto done = device_->launch(Kernel::march_strata, march, band.blocks); !done) return done;
    if (auto done = queue_gather(p.strata, strata, directions, false); !done) return done;
    const RefineArgs refine{lists(band.blocks),     strata,           p.strata.offset.data(),
                            {answer(0), answer(1)}, p.weights.data(), refined};
    if (auto done = device_->launch(Kernel::refine_strata, refine, band.blocks); !done) return done;
    const PickArgs pick{scene(),
                        p.directions.data() + 3 * band.first_pixel,
                        p.block.data() + band.first_pixel,
                        p.block_place.data() + band.first_block,
                        strata,
                        refined,
                        p.pixels.of(band.pixels, p.options.max_samples),
                        p.alone.data(),
                        p.alone_count.data()};
    if (auto done = device_->clear(p.alone_count.data(), sizeof(std::uint32_t)); !done) return done;
    if (auto done = device_->launch(Kernel::pick_samples, pick, band.pixels); !done) return done;
    return queue_march(band, true);
  }

  Result<void> queue_pixels(const PictureBand& band) {
    const Picture& p = *picture_;
    const PlacedRays rays = p.pixels.of(band.pixels, p.options.max_samples);
    if (auto done = queue_gather(p.pixels, rays, p.directions.data() + 3 * band.first_pixel, true); !done)
      return done;
    for (const DevicePart& part : parts_)
      if (part.field)
        if (auto done = part.field->colour(); !done) return done;
    const CompositeArgs composite{
        rays,          p.pixels.offset.data(), {answer(0), answer(1)},      p.place.data() + band.first_pixel,
        p.rgba.data(), p.options.shade_weight, p.options.stop_transmittance};
    return device_->launch(Kernel::composite_pixels, composite, band.pixels);
  }

  std::shared_ptr<Device> device_;
  const Avatar& avatar_;
  bool halves_;
  std::array<DevicePart, 2> parts_;
  DeviceArray<float> depths_;
  DeviceArray<std::uint8_t> neck_cells_;
  std::optional<Picture> picture_;
  std::vector<unsigned char> packed_;
  DeviceArray<unsigned char> frame_;
  void* recording_ = nullptr;
};

}  // namespace

Result<std::unique_ptr<FrameRenderer>> device_renderer(std::shared_ptr<Device> device, const Avatar& avatar,
                                                       bool halves) {
  auto renderer = std::make_unique<DeviceRenderer>(std::move(device), avatar, halves);
  if (auto done = renderer->prepare(); !done) return done.error();
  return std::unique_ptr<FrameRenderer>(std::move(renderer));
}

}  // namespace likeness

// Tables and order of the kernels: see cast_rays.h.
#include "core/train/cast_rays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/field/device_field.h"
#include "core/render/device_frame.h"
#include "core/train/device_rays.h"

namespace likeness {

RayCaster::~RayCaster() = default;

namespace {

constexpr std::size_t kMaxNeckViews = 65535;                 // a row of blocks per view
constexpr std::size_t kMaxNeckBytes = std::size_t{1} << 30;  // and an eighth of the free memory

template <class T>
Result<void> make(const std::shared_ptr<Device>& device, DeviceArray<T>& array, std::size_t count) {
  auto made = DeviceArray<T>::make(device, std::max<std::size_t>(1, count));
  if (!made) return made.error();
  array = std::move(*made);
  return {};
}

// The host's copy must stay until the device has been waited for.
template <class T>
Result<void> upload(const std::shared_ptr<Device>& device, DeviceArray<T>& array,
                    const std::vector<T>& from) {
  if (array.size() < from.size() || array.size() == 0)
    if (auto done = make(device, array, from.size()); !done) return done;
  return device->copy_in(array.data(), from.data(), from.size() * sizeof(T));
}

std::size_t pixels_of(const Image8& image) { return image.pixels(); }

// Where plates lie, each once.
std::map<const Image8*, PlateOfView> plates_of(const TrainingSet& set) {
  std::map<const Image8*, PlateOfView> plates;
  for (const TrainingView& view : set.views)  // proxies have none
    if (const PlateOfView plate = plate_of(set, view); !plate.rgb->empty()) plates[plate.rgb] = plate;
  return plates;
}

// (h, w) red, green, blue, and above them `fourth` of the pixel.
template <class Fourth>
void pack_pixels(const Image8& rgb, const Fourth& fourth, std::vector<std::uint32_t>& out) {
  out.resize(pixels_of(rgb));
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x) {
      const std::uint8_t* p = rgb.at(x, y);
      out[std::size_t(y) * std::size_t(rgb.width) + std::size_t(x)] =
          std::uint32_t(p[0]) | std::uint32_t(p[1]) << 8 | std::uint32_t(p[2]) << 16 |
          std::uint32_t(fourth(x, y)) << 24;
    }
}

// A field's grids, and what is known of their cells.
struct Cells {
  const TrainedField* field = nullptr;  // null: there is no such field
  DeviceArray<std::uint32_t> cells;
  DeviceArray<float> density;  // of all cells
  DeviceArray<std::uint8_t> allowed, kept, core, bits, opacity, bricks;
  std::vector<float> host_density;
  std::vector<std::uint8_t> host_opacity;

  int n() const { return field->part.occupancy.resolution; }
  std::size_t count() const { return std::size_t(n()) * std::size_t(n()) * std::size_t(n()); }
  std::size_t brick_count() const {
    const auto m = std::size_t(bricks_along(n()));
    return m * m * m;
  }
  const std::uint8_t* core_bits() const { return field->part.core.resolution == n() ? core.data() : nullptr; }
  MarchGrid grid() const {
    if (!field) return {};
    const FieldCube& cube = field->part.cube;
    return {1,
            n(),
            {cube.origin.x(), cube.origin.y(), cube.origin.z()},
            cube.side,
            bits.data(),
            core_bits(),
            opacity.data(),
            bricks.data()};
  }

  // Allocates what never changes.
  Result<void> allocate(const std::shared_ptr<Device>& device) {
    if (auto done = upload(device, cells, field->learnt.cells); !done) return done;
    if (auto done = upload(device, allowed, field->volume.allowed.bits); !done) return done;
    if (auto done = upload(device, kept, field->volume.kept.bits); !done) return done;
    if (auto done = upload(device, core, field->part.core.bits); !done) return done;
    if (auto done = make(device, density, count()); !done) return done;
    if (auto done = make(device, bits, field->part.occupancy.bits.size()); !done) return done;
    if (auto done = make(device, opacity, count()); !done) return done;
    return make(device, bricks, brick_count());
  }
  Result<void> place(const std::shared_ptr<Device>& device) {
    host_density.assign(count(), 0.f);
    for (std::size_t i = 0; i < field->learnt.cells.size(); ++i)
      host_density[field->learnt.cells[i]] = field->learnt.density[i];
    host_opacity = field->part.opacity;
    host_opacity.resize(count(), 0);
    if (auto done = upload(device, density, host_density); !done) return done;
    if (auto done = upload(device, opacity, host_opacity); !done) return done;
    return upload(device, bits, field->part.occupancy.bits);
  }
};

class Caster : public RayCaster {
 public:
  Caster(const DeviceBatch& batch, const TrainingState& state, const RaySource& source,
         const StepOptions& options)
      : batch_(batch),
        device_(batch.device),
        set_(*source.set),
        options_(options),
        views_(source.views.size()) {
    cells_[0].field = &state.head;
    if (state.torso) cells_[1].field = &*state.torso;
  }

  Result<void> prepare(const TrainingState& state, const RaySource& source) {
    if (auto done = place_pictures(); !done) return done;
    for (Cells& cells : cells_)
      if (cells.field)
        if (auto done = cells.allocate(device_); !done) return done;
    const auto rays = std::size_t(options_.rays), most = std::size_t(kTrainingSamples);
    if (auto done = make(device_, direction_, 3 * rays); !done) return done;
    if (auto done = make(device_, from_, 2 * rays); !done) return done;
    if (auto done = make(device_, jitter_, rays); !done) return done;
    if (auto done = make(device_, row_, rays); !done) return done;
    if (auto done = make(device_, t_, rays * most); !done) return done;
    if (auto done = make(device_, dt_, rays * most); !done) return done;
    if (auto done = make(device_, count_, 2 * rays); !done) return done;
    if (auto done = make(device_, offset_, 2 * rays); !done) return done;
    if (auto done = make(device_, step_, 1); !done) return done;
    std::size_t stretches = 0;
    for (const Cells& cells : cells_) stretches += rows_of(cells);
    for (DeviceArray<float>* array : {&near_, &far_, &depth_})
      if (auto done = make(device_, *array, stretches * lanes()); !done) return done;
    if (auto done = make(device_, layers_, std::size_t(bricks_along(cells_[0].n()))); !done) return done;
    const std::vector<float> depths(depth_of_opacity().begin(), depth_of_opacity().end());
    if (auto done = upload(device_, depths_, depths); !done) return done;
    if (auto done = upload(device_, still_, state.head.volume.still.bits); !done) return done;
    if (auto done = upload(device_, sides_, source.sides.bits); !done) return done;
    still_n_ = state.head.volume.still.resolution, sides_n_ = source.sides.resolution;
    if (auto done = device_->wait(); !done) return done;
    if (auto done = place_cells(state); !done) return done;
    if (auto done = place_views(source); !done) return done;
    make_room_for_necks(source);
    if (auto done = queue_bounds(); !done) return done;
    return device_->wait();
  }

  Result<void> place_views(const RaySource& source) override {
    std::vector<unsigned char> all, one;
    for (std::size_t v = 0; v < views_; ++v) {
      FrameParts parts;
      for (std::size_t f = 0; f < 2; ++f)
        if (cells_[f].field) parts.maps[f] = &source.views[v].maps[f];
      if (!source.necks.empty()) parts.neck = &source.necks[v];
      if (!source.warps.empty()) parts.warp = &source.warps[v];
      if (!source.torsos.empty()) parts.torso = &source.torsos[v];
      pack_frame(parts, nullptr, one);
      const std::size_t at = (all.size() + 15) / 16 * 16;
      all.resize(at + one.size());
      std::copy(one.begin(), one.end(), all.begin() + std::ptrdiff_t(at));
      RayView& view = host_views_[v];
      const RaySource::View& own = source.views[v];
      view.frame = at;
      view.face = {own.face_x0, own.face_y0, own.face_x1, own.face_y1};
      std::copy_n(own.gain.data(), 3, view.gain);
    }
    drawn_ = std::min(source.drawn, set_.views.size());
    proxies_until_ = source.proxies_until;
    ++version_;  // addresses and these numbers are part of what is recorded
    if (auto done = upload(device_, frames_, all); !done) return done;
    if (auto done = upload(device_, view_, host_views_); !done) return done;
    if (auto done = queue_bounds(); !done) return done;
    return device_->wait();
  }

  Result<void> place_cells(const TrainingState&) override {
    for (Cells& cells : cells_)
      if (cells.field)
        if (auto done = cells.place(device_); !done) return done;
    refreshed_ = false;
    if (auto done = queue_bounds(); !done) return done;
    return device_->wait();
  }

  Result<void> fetch_cells(TrainingState& state) override {
    if (!refreshed_) return {};
    for (Cells& cells : cells_)
      if (cells.field)
        if (auto done = device_->copy_out(cells.host_density.data(), cells.density.data(),
                                          cells.count() * sizeof(float));
            !done)
          return done;
    if (auto done = device_->wait(); !done) return done;
    for (std::size_t f = 0; f < 2; ++f) {
      if (!cells_[f].field) continue;
      TrainedField& field = f == 0 ? state.head : *state.torso;
      for (std::size_t i = 0; i < field.learnt.cells.size(); ++i)
        field.learnt.density[i] = cells_[f].host_density[field.learnt.cells[i]];
      field.part.occupancy = occupancy_bits(field.learnt, field.volume);
      field.part.opacity = cell_opacities(field.learnt, field.volume);
    }
    return {};
  }

  Result<void> set_step(std::uint64_t step) override {
    host_step_ = step;
    return device_->copy_in(step_.data(), &host_step_, sizeof(host_step_));
  }

  std::uint64_t version() const override { return version_; }

  Result<void> queue_rays(const DeviceBatch& batch) override {
    const auto own = std::uint32_t(own_views(set_).size());
    const MarchScene scene = this->scene();
    const auto rays = std::uint32_t(options_.rays);
    const CastRays cast{direction_.data(), from_.data(), jitter_.data(), row_.data(), rays};
    const PlacedRays placed{t_.data(), dt_.data(), count_.data(), rays, kTrainingSamples};
    const ChoiceNumbers numbers{options_.seed,
                                0,
                                std::uint32_t(views_),
                                own,
                                std::uint32_t(drawn_),
                                0,
                                std::uint32_t(rays),
                                options_.use_latent ? 1 : 0,
                                std::uint32_t(views_ - set_.views.size()),
                                proxies_until_};
    const ChooseRaysArgs choose{scene, ray_views(),  numbers,         step_.data(),
                                cast,  batch.target, batch.background};
    if (auto done = device_->launch(Kernel::choose_rays, choose, rays); !done) return done;
    const ListMemory lists{near_.data(),           far_.data(),
                           depth_.data(),          nullptr,
                           std::uint32_t(lanes()), std::int32_t(rows_of(cells_[0]))};
    const MarchChosenArgs march{scene, ray_views(), cast, lists, options_.even_samples, placed};
    if (auto done = device_->launch(Kernel::march_chosen, march, lanes()); !done) return done;
    OrderedOffsetsArgs offsets{placed, offset_.data(), batch.begin, {}, batch.numbers, batch.sums};
    GatherChosenArgs gather{scene,
                            ray_views(),
                            cast,
                            placed,
                            offset_.data(),
                            batch.begin,
                            options_.seed,
                            step_.data(),
                            own,
                            {still_n_, still_.data()},
                            {options_.use_latent && own < set_.views.size() ? sides_n_ : 0, sides_.data()},
                            {},
                            {},
                            batch.dt,
                            batch.of_field,
                            batch.slot};
    for (std::size_t f = 0; f < 2; ++f) {
      const DeviceField* field = batch.fields[f];
      if (!field) continue;
      offsets.total[f] = field->count(), gather.row[f] = field->rows();
      for (int k = 0; k < 6; ++k) gather.point[f][k] = field->point(k);
    }
    if (auto done = device_->launch(Kernel::ordered_offsets, offsets, rays); !done) return done;
    return device_->launch(Kernel::gather_chosen, gather, std::size_t(rays) * kTrainingSamples);
  }

  Result<void> refresh(std::uint64_t step) override {
    for (std::size_t f = 0; f < 2; ++f) {
      if (!cells_[f].field) continue;
      Cells& cells = cells_[f];
      DeviceField& field = *batch_.fields[f];
      const std::size_t all = cells.field->learnt.cells.size();
      for (std::size_t first = 0; first < all; first += field.capacity()) {
        const std::size_t count = std::min(field.capacity(), all - first);
        LookUpArgs look{scene(),
                        ray_views(),
                        cells.cells.data(),
                        std::uint32_t(first),
                        std::uint32_t(count),
                        std::int32_t(f),
                        options_.seed,
                        step,
                        {},
                        field.rows(),
                        field.count()};
        for (int k = 0; k < 6; ++k) look.point[k] = field.point(k);
        if (auto done = device_->launch(Kernel::look_up_cells, look, count); !done) return done;
        if (auto done = field.density(count); !done) return done;
        const DecayArgs decay{cells.cells.data(), std::uint32_t(first), std::uint32_t(count), field.sigma(),
                              cells.density.data()};
        if (auto done = device_->launch(Kernel::decay_cells, decay, count); !done) return done;
      }
      const CellBitsArgs bits{cells.n(),         cells.density.data(), cells.allowed.data(),
                              cells.kept.data(), cells.bits.data(),    cells.opacity.data()};
      if (auto done = device_->launch(Kernel::set_cell_bits, bits, (cells.count() + 7) / 8); !done)
        return done;
    }
    refreshed_ = true;
    return queue_bounds();
  }

 private:
  static std::size_t rows_of(const Cells& cells) { return cells.field ? std::size_t(3 * cells.n()) : 0; }
  std::size_t lanes() const { return std::size_t(options_.rays); }

  MarchScene scene() const {
    const MarchVolumes usual;
    return {{cells_[0].grid(), cells_[1].grid()},
            depths_.data(),
            nullptr,
            nullptr,
            usual.near,
            usual.far,
            usual.min_step};
  }
  RayViews ray_views() const {
    return {view_.data(),          pixels_.data(),     teaches_.data(),          frames_.data(),
            std::uint32_t(views_), neck_cells_.data(), std::uint32_t(neck_room_)};
  }

  // Bricks, and the boxes of the necks by them.
  Result<void> queue_bounds() {
    for (const Cells& cells : cells_) {
      if (!cells.field) continue;
      const BricksArgs bricks{cells.n(), cells.bits.data(), cells.core_bits(), cells.bricks.data()};
      if (auto done = device_->launch(Kernel::mark_bricks, bricks, cells.brick_count()); !done) return done;
    }
    if (frames_.size() == 0) return {};
    const int n = cells_[0].n();
    const LayersArgs layers{n, cells_[0].bricks.data(), layers_.data()};
    if (auto done = device_->launch(Kernel::bound_layers, layers, layers_.size()); !done) return done;
    const NeckBoxArgs necks{n, layers_.data(), ray_views()};
    if (auto done = device_->launch(Kernel::bound_necks, necks, views_); !done) return done;
    if (neck_room_ == 0) return {};
    const FillNecksArgs fill{cells_[0].grid(), ray_views()};
    return device_->launch(Kernel::fill_necks, fill, views_ * neck_room_);
  }

  // A bent neck's cells are looked up for every view at intervals instead of by every ray, if there is memory
  // for them.
  void make_room_for_necks(const RaySource& source) {
    if (source.necks.empty() || views_ > kMaxNeckViews) return;
    const std::size_t most = std::min(kMaxNeckBytes, std::size_t(device_->facts().free_bytes / 8));
    const std::size_t room = std::min(cells_[0].count() / 4, most / (2 * views_));
    if (!make(device_, neck_cells_, 2 * views_ * room)) return;  // every ray then looks them up itself
    neck_room_ = room;
    ++version_;
  }

  // Once: pictures do not change. One picture at a time, so that the host holds at most one copy.
  Result<void> place_pictures() {
    const auto plates = plates_of(set_);
    host_views_.assign(views_, {});
    std::map<const Image8*, std::int64_t> plate_at;
    std::size_t pixels = 0, bits = 0;
    for (const auto& [rgb, plate] : plates) plate_at[rgb] = std::int64_t(pixels), pixels += pixels_of(*rgb);
    for (std::size_t v = 0; v < views_; ++v) {
      const TrainingView& from = picture_at(set_, v);
      const Intrinsics& k = from.camera.intrinsics;
      RayView& view = host_views_[v];
      view.lens = {k.fx, k.fy, k.cx, k.cy, k.k1, k.k2, k.p1, k.p2};
      view.width = from.rgb.width, view.height = from.rgb.height;
      view.further = from.further_clip != 0, view.has_alpha = !from.alpha.empty();
      const LearntPart part = learnt_part(from);
      view.alone = part == LearntPart::person ? -1 : part == LearntPart::head ? 0 : 1;
      const PlateOfView plate = plate_of(set_, from);
      view.plate = plate.rgb->empty() ? -1 : plate_at[plate.rgb];
      view.mosaic = mosaic_place(set_, from);
      view.pixels = pixels, pixels += pixels_of(from.rgb);
      view.teaches = from.teaches.empty() ? -1 : std::int64_t(bits);
      if (!from.teaches.empty()) bits += (pixels_of(from.rgb) + 7) / 8 * 8;
    }
    if (auto done = make(device_, pixels_, pixels); !done) return done;
    if (auto done = make(device_, teaches_, bits / 8); !done) return done;
    std::vector<std::uint32_t> packed;
    const auto send = [&](std::size_t at) -> Result<void> {
      if (auto done = device_->copy_in(pixels_.data() + at, packed.data(), packed.size() * 4); !done)
        return done;
      return device_->wait();
    };
    for (const auto& [rgb, plate] : plates) {
      const Image8& known = *plate.known;
      pack_pixels(
          *rgb, [&](int x, int y) { return known.empty() ? 255 : known.at(x, y)[0]; }, packed);
      if (auto done = send(std::size_t(plate_at[rgb])); !done) return done;
    }
    for (std::size_t v = 0; v < views_; ++v) {
      const TrainingView& from = picture_at(set_, v);
      pack_pixels(
          from.rgb, [&](int x, int y) { return from.alpha.empty() ? 255 : from.alpha.at(x, y); }, packed);
      if (auto done = send(host_views_[v].pixels); !done) return done;
      if (!from.teaches.empty())
        if (auto done = send_teaches(from, std::size_t(host_views_[v].teaches) / 8); !done) return done;
    }
    return {};
  }

  Result<void> send_teaches(const TrainingView& view, std::size_t at) {
    std::vector<std::uint8_t> bits((pixels_of(view.rgb) + 7) / 8, 0);
    for (int y = 0, i = 0; y < view.rgb.height; ++y)
      for (int x = 0; x < view.rgb.width; ++x, ++i)
        if (view.teaches.at(x, y) > 0) bits[std::size_t(i >> 3)] |= std::uint8_t(1u << (i & 7));
    if (auto done = device_->copy_in(teaches_.data() + at, bits.data(), bits.size()); !done) return done;
    return device_->wait();
  }

  DeviceBatch batch_;
  std::shared_ptr<Device> device_;
  const TrainingSet& set_;
  StepOptions options_;
  std::size_t views_, drawn_ = 0;
  std::array<Cells, 2> cells_;
  std::vector<RayView> host_views_;
  DeviceArray<RayView> view_;
  DeviceArray<std::uint32_t> pixels_, count_, offset_;
  DeviceArray<std::uint8_t> teaches_, still_, sides_, neck_cells_;
  std::size_t neck_room_ = 0;  // cells per view
  DeviceArray<unsigned char> frames_;
  DeviceArray<float> direction_, from_, t_, dt_, near_, far_, depth_, depths_;
  DeviceArray<std::uint64_t> jitter_, step_;
  DeviceArray<std::int32_t> row_;
  DeviceArray<BrickLayer> layers_;
  int still_n_ = 0, sides_n_ = 0;
  std::uint64_t proxies_until_ = UINT64_MAX;
  std::uint64_t host_step_ = 0, version_ = 0;
  bool refreshed_ = false;  // the device's cells are newer than the host's
};

}  // namespace

std::size_t picture_bytes(const TrainingSet& set) {
  std::size_t bytes = 0;
  for (const auto& [rgb, plate] : plates_of(set)) bytes += 4 * pixels_of(*rgb);
  for (std::size_t v = 0; v < pictured(set); ++v) {
    const TrainingView& view = picture_at(set, v);
    bytes += 4 * pixels_of(view.rgb) + (view.teaches.empty() ? 0 : pixels_of(view.rgb) / 8);
  }
  return bytes;
}

CasterChoice make_ray_caster(FieldLearner& learner, const TrainingState& state, const RaySource& source,
                             const StepOptions& options) {
  const DeviceBatch* batch = learner.device_batch();
  if (!batch) return {};
  const auto processor = [](const std::string& why) {
    return CasterChoice{nullptr, why + " The processor casts the rays."};
  };
  if (state.head.canonical) return processor("Cells of the canonical face are looked up by the processor.");
  if (source.patches) return processor("The landmark loss chooses its own pixels.");
  const double gib = double(1 << 30);
  std::size_t bytes = picture_bytes(*source.set);
  for (const WarpLattice& warp : source.warps) bytes += warp.bytes();
  if (const std::size_t free = batch->device->facts().free_bytes; bytes > free / 2)
    return processor(fmt::format("The pictures take {:.1f} GiB, more than half of the GPU's free {:.1f}.",
                                 double(bytes) / gib, double(free) / gib));
  auto caster = std::make_unique<Caster>(*batch, state, source, options);
  if (auto done = caster->prepare(state, source); !done) return processor(done.error().what);
  return {std::move(caster), ""};
}

}  // namespace likeness

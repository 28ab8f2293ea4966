// Claims about provenance: every file written for a film states its provenance, readable by other programs.
#include "core/export/provenance.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/export/mark.h"
#include "core/export/write_film.h"
#include "core/image/files.h"
#include "core/project/consent.h"
#include "core/render/camera_path.h"
#include "core/video/copy_sound.h"
#include "tests/core/export/tiny_project.h"
#include "tests/support/run_program.h"

namespace likeness::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

class ProvenanceOfFiles : public testing::Test {
 protected:
  // From the project on disk, as the program does it.
  fs::path film(const char* name, std::size_t frames, bool mark = false, bool alpha = false) {
    auto opened = open_avatar(project_.folder());
    EXPECT_TRUE(opened.ok());
    hash_ = opened->avatar_hash;
    const Film film = resting_film(opened->avatar, frames);
    FilmOptions options{.out = project_.root / name, .alpha = alpha, .mark = mark};
    options.made_at = std::chrono::system_clock::from_time_t(1'700'000'000);  // 2023-11-14 22:13:20 UTC
    const auto written = write_film(*opened, film, options, Progress(), {});
    EXPECT_TRUE(written.ok()) << written.error().what;
    return options.out;
  }
  void expect_facts(const json& facts) const {
    EXPECT_EQ(facts.at("synthetic"), true);
    EXPECT_EQ(facts.at("digital_source_type"), kDigitalSourceType);
    EXPECT_THAT(facts.at("made_by").get<std::string>(), testing::StartsWith("Likeness "));
    EXPECT_EQ(facts.at("project"), "someone");
    EXPECT_EQ(facts.at("avatar_hash"), hash_);
    EXPECT_EQ(facts.at("made_at"), "2023-11-14T22:13:20Z");
    EXPECT_EQ(facts.at("consent"), consent_name(Consent::not_asked));
  }

  TinyProject project_;
  std::string hash_;
};

TEST_F(ProvenanceOfFiles, OpenImageIOReadsItFromAPng) {
  for (const bool alpha : {false, true}) {
    const auto input = OIIO::ImageInput::open(film("still.png", 1, false, alpha).string());
    ASSERT_NE(input, nullptr);
    const OIIO::ImageSpec& spec = input->spec();
    expect_facts(json::parse(spec.get_string_attribute("Provenance")));
    EXPECT_THAT(spec.get_string_attribute("ImageDescription"), HasSubstr("Synthetic media"));
    EXPECT_THAT(spec.get_string_attribute("ImageDescription"), HasSubstr("agreed was not answered"));
    std::vector<unsigned char> pixels(std::size_t(spec.width) * std::size_t(spec.height) *
                                      std::size_t(spec.nchannels));
    EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, pixels.data()));
  }
}

TEST_F(ProvenanceOfFiles, ThatSomebodyAgreedIsSaidToo) {
  ASSERT_TRUE(change_project(project_.folder(), [](Project& p) { p.consent = Consent::given; }).ok());
  const auto input = OIIO::ImageInput::open(film("still.png", 1).string());
  ASSERT_NE(input, nullptr);
  const json facts = json::parse(input->spec().get_string_attribute("Provenance"));
  EXPECT_EQ(facts.at("consent"), "given");
  EXPECT_THAT(input->spec().get_string_attribute("ImageDescription"), Not(HasSubstr("agreed")));
}

TEST_F(ProvenanceOfFiles, EveryPictureOfASequenceHasIt) {
  const fs::path folder = film("frames", 2);
  for (const char* name : {"000000.png", "000001.png"}) {
    const auto input = OIIO::ImageInput::open((folder / name).string());
    ASSERT_NE(input, nullptr);
    expect_facts(json::parse(input->spec().get_string_attribute("Provenance")));
  }
}

TEST_F(ProvenanceOfFiles, FfprobeReadsItFromAnMp4EvenAfterSoundIsAdded) {
  const fs::path video = film("film.mp4", 5), sound = project_.root / "sound.mp4";
  const auto tags = [&]() -> json {
    const ProgramResult probed =
        run_program({"ffprobe", "-v", "error", "-show_entries", "format_tags:stream=codec_type", "-of",
                     "json", video.string()});
    EXPECT_EQ(probed.exit_code, 0) << probed.err;
    return json::parse(probed.out);
  };
  if (run_program({"ffprobe", "-version"}).exit_code != 0)
    GTEST_SKIP() << "the ffprobe program is not installed";
  const json silent = tags().at("format").at("tags");
  expect_facts(json::parse(silent.at("provenance").get<std::string>()));
  EXPECT_THAT(silent.at("comment").get<std::string>(), HasSubstr("Synthetic media"));
  EXPECT_EQ(silent.at("digital_source_type"), kDigitalSourceType);

  ASSERT_EQ(run_program({"ffmpeg", "-v", "error", "-f", "lavfi", "-i", "testsrc=size=64x64:duration=1", "-f",
                         "lavfi", "-i", "sine=duration=1", "-shortest", sound.string()})
                .exit_code,
            0);
  const auto copied = copy_sound(sound, video);
  ASSERT_TRUE(copied.ok() && copied->copied);
  const json both = tags();
  EXPECT_EQ(both.at("streams").size(), 2u);
  EXPECT_EQ(both.at("format").at("tags").at("provenance"), silent.at("provenance"));
}

TEST(Provenance, ProjectNamesAreEscapedInEveryFormat) {
  const Provenance odd = provenance("a \"b\" <c> & \xFF\n", "12", {});
  EXPECT_TRUE(
      json::parse(provenance_json(odd)).at("project").get<std::string>().starts_with("a \"b\" <c> & "));
  EXPECT_EQ(odd.made_at, "1970-01-01T00:00:00Z");
  const std::string xmp = provenance_xmp(odd);
  EXPECT_THAT(xmp, HasSubstr(std::string("Iptc4xmpExt:DigitalSourceType=\"") + kDigitalSourceType + "\""));
}

TEST_F(ProvenanceOfFiles, TheMarkIsInItsCornerAndNowhereElse) {
  for (const bool alpha : {false, true}) {
    const auto plain = read_image(film("plain.png", 1, false, alpha));
    const auto marked = read_image(film("marked.png", 1, true, alpha));
    ASSERT_TRUE(plain.ok() && marked.ok());
    int changed = 0, light = 0;
    for (int y = 0; y < plain->height; ++y)
      for (int x = 0; x < plain->width; ++x) {
        if (std::equal(plain->at(x, y), plain->at(x, y) + plain->channels, marked->at(x, y))) continue;
        ++changed;
        light += *marked->at(x, y) > 200;
        EXPECT_GE(y, plain->height * 3 / 4);
        EXPECT_TRUE(!alpha || marked->at(x, y)[3] > 0);
      }
    EXPECT_GT(changed, 50);
    EXPECT_GT(light, 10);
  }
}

}  // namespace
}  // namespace likeness::test

// The same few facts in each format's terms: see provenance.h.
#include "core/export/provenance.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/json_text.h"

namespace likeness {

Provenance provenance(const std::string& project, const std::string& avatar_hash,
                      std::chrono::system_clock::time_point made_at) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(made_at);
  // Through JSON, whose writer replaces what is not UTF-8.
  const std::string readable = parse_json(json_text(nlohmann::json(project)));
  return {"Likeness " LIKENESS_VERSION, readable, avatar_hash,
          fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(seconds)), ""};
}

std::string provenance_sentence(const Provenance& p) {
  return fmt::format("Synthetic media, not a recording: made by {} from the avatar \"{}\" ({}), {}.{}",
                     p.program, p.project, p.avatar_hash, p.made_at,
                     p.consent == "not_asked" ? " Whether the person shown agreed was not answered." : "");
}

std::string provenance_json(const Provenance& p) {
  return json_text({{"synthetic", true},
                    {"digital_source_type", kDigitalSourceType},
                    {"made_by", p.program},
                    {"project", p.project},
                    {"avatar_hash", p.avatar_hash},
                    {"consent", p.consent.empty() ? nlohmann::json() : nlohmann::json(p.consent)},
                    {"made_at", p.made_at}});
}

std::string provenance_xmp(const Provenance& p) {
  return fmt::format(
      "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">"
      "<rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">"
      "<rdf:Description rdf:about=\"\" xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\""
      " xmlns:Iptc4xmpExt=\"http://iptc.org/std/Iptc4xmpExt/2008-02-29/\""
      " Iptc4xmpExt:DigitalSourceType=\"{}\" xmp:CreatorTool=\"{}\" xmp:CreateDate=\"{}\"/>"
      "</rdf:RDF></x:xmpmeta><?xpacket end=\"r\"?>",
      kDigitalSourceType, p.program, p.made_at);
}

std::vector<std::pair<std::string, std::string>> png_provenance(const Provenance& p) {
  return {{"Description", provenance_sentence(p)},
          {"Software", p.program},
          {"Provenance", provenance_json(p)},
          {"XML:com.adobe.xmp", provenance_xmp(p)}};
}

std::vector<std::pair<std::string, std::string>> mp4_provenance(const Provenance& p) {
  return {{"comment", provenance_sentence(p)},
          {"provenance", provenance_json(p)},
          {"digital_source_type", kDigitalSourceType}};
}

}  // namespace likeness

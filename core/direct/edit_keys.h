// Editing the keys of a performance. A key is identified by its channel and its time, which stay valid while
// other keys come and go.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/direct/performance.h"

namespace likeness {

struct KeyPlace {
  std::string channel;
  double time_s = 0;
  bool operator==(const KeyPlace&) const = default;
};

// Keys copied out of their performance; the earliest is at time 0.
struct KeyClip {
  std::map<std::string, std::vector<Key>> channels;
};

// nullptr if there is no key at that time (within kSameTime_s).
const Key* find_key(const Performance& performance, const KeyPlace& place);
std::vector<KeyPlace> all_keys(const Performance& performance);

// Inserts a key, or replaces the one at its time. An invalid channel name is a programmer's mistake.
void set_key(Performance& performance, const std::string& channel, const Key& key);
// Places without a key are skipped, here and below.
void erase_keys(Performance& performance, std::span<const KeyPlace> places);

// Shifts keys together, no further than to the start; unmoved keys that they meet are replaced. Returns where
// they are now.
std::vector<KeyPlace> move_keys(Performance& performance, std::span<const KeyPlace> places, double by_s);

void set_easing(Performance& performance, std::span<const KeyPlace> places, Easing easing);

KeyClip copy_keys(const Performance& performance, std::span<const KeyPlace> places);
// The clip's start at `at_s` (>= 0); replaces keys it meets. The performance grows to hold it. Returns the
// new keys.
std::vector<KeyPlace> paste_keys(Performance& performance, const KeyClip& clip, double at_s);

// Puts a take in place of what head and face do from `at_s` on for its length; elsewhere they stay as they
// were. The performance grows to hold it.
void lay_over(Performance& performance, const Performance& take, double at_s);

// The channel for the face's other side: action mouthSmile_L and _R; for eyes that look to a side, the other
// eye looking the same way (eyeLookIn_L and eyeLookOut_R). Empty where a channel has no such partner.
std::string linked_channel(std::string_view channel);

}  // namespace likeness

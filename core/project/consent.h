// The person's answer in a word, for files and programs.
#pragma once

#include <string_view>

namespace likeness {

enum class Consent;  // core/project/project.h

std::string_view consent_name(Consent consent);  // as written there

}  // namespace likeness

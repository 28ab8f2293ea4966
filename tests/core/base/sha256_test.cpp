// Claims about SHA-256: the standard's own examples, and every way in which a message can end in a block.
#include "core/base/sha256.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace likeness {
namespace {

std::string sha256_of(const std::string& text) { return sha256(std::as_bytes(std::span(text))); }

// FIPS 180-4's example messages and NIST's long one.
TEST(Sha256, IsTheStandards) {
  EXPECT_EQ(sha256_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256_of(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

// Lengths around those at which the padding takes another block; the hashes are those of sha256sum.
TEST(Sha256, KnowsWhereBlocksEnd) {
  EXPECT_EQ(sha256_of(std::string(55, 'a')),
            "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318");
  EXPECT_EQ(sha256_of(std::string(56, 'a')),
            "b35439a4ac6f0948b6d6f9e3c6af0f5f590ce20f1bde7090ef7970686ec6738a");
  EXPECT_EQ(sha256_of(std::string(64, 'a')),
            "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb");
  std::set<std::string> different;
  for (std::size_t length = 0; length < 200; ++length) different.insert(sha256_of(std::string(length, '\0')));
  EXPECT_EQ(different.size(), 200u);
}

}  // namespace
}  // namespace likeness

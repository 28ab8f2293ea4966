// Claims about reading pickles: every protocol's data comes out, nothing is executed, every fault names its
// byte, and no small file takes much memory or time.
#include "core/head/pickle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/core/head/bytes_of.h"
#include "tests/core/head/pickle_writer.h"

namespace likeness {
namespace {

using namespace std::string_literals;
using ::testing::HasSubstr;

std::string pickle_fault(const std::string& pickle) {
  const auto document = read_pickle(bytes_of(pickle), "x.pkl");
  if (document) return "no fault found";
  EXPECT_EQ(document.error().code, ErrorCode::bad_input);
  EXPECT_EQ(document.error().where, "x.pkl");
  EXPECT_FALSE(document.error().fix.empty());
  return document.error().what;
}

std::string quoted(const char* before, std::string_view text) { return std::string(before).append(text); }

// Compact text of a value, to compare with.
std::string shown(const PickleDocument& d, PickleRef ref, int depth = 0) {
  const PickleNode& n = d.node(ref);
  if (depth > 6) return "...";
  const auto items = [&](const char* open, const char* close) {
    std::string out = open;
    for (const PickleRef item : n.items) out += shown(d, item, depth + 1) + ",";
    return out + close;
  };
  switch (n.kind) {
    case PickleKind::none:
      return "None";
    case PickleKind::boolean:
      return n.integer ? "True" : "False";
    case PickleKind::integer:
      return std::to_string(n.integer);
    case PickleKind::real:
      return std::to_string(n.real);
    case PickleKind::text:
      return quoted("u'", n.text) + "'";
    case PickleKind::bytes:
      return quoted("'", n.text) + "'";
    case PickleKind::list:
      return items("[", "]");
    case PickleKind::tuple:
      return items("(", ")");
    case PickleKind::dict:
      return items("{", "}");
    case PickleKind::set:
      return items("<", ">");
    case PickleKind::global:
      return quoted("@", n.text);
    case PickleKind::object:
      return items("!", "!");
    case PickleKind::persistent:
      return items("#", "#");
  }
  return "?";
}

std::string read_as_text(const std::string& pickle) {
  const auto document = read_pickle(bytes_of(pickle), "x.pkl");
  return document ? shown(*document, document->root) : document.error().what;
}

TEST(ReadPickle, ReadsTheTextProtocol) {
  EXPECT_EQ(read_as_text(
                "(dp0\nS'a\\n\\x41'\np1\nI01\nsVb\\u0041\\u00e9\xe9\nL-12345678901L\nsS\"c\"\n(lp2\nI5\naF1."
                "5\na(NI-3\ntas."),
            "{'a\nA',True,u'bA\xc3\xa9\xc3\xa9',-12345678901,'c',[5,1.500000,(None,-3,),],}");
}

TEST(ReadPickle, ReadsBinaryProtocolsTwoToFive) {
  EXPECT_EQ(
      read_as_text("\x80\x02}(U\x01"s + "aK\x07U\x01" + "bJ\xfe\xff\xff\xffU\x01"s + "cM\x00\x01U\x01"s +
                   "dG\x3f\xf8\x00\x00\x00\x00\x00\x00U\x01"s + "e\x8a\x02\x00\xffu."s),
      "{'a',7,'b',-2,'c',256,'d',1.500000,'e',-256,}");
  EXPECT_EQ(read_as_text("\x80\x03(C\x02hiX\x03\x00\x00\x00xyz\x88\x89Nt."s),
            "('hi',u'xyz',True,False,None,)");
  EXPECT_EQ(
      read_as_text(
          "\x80\x04\x95\x12\x00\x00\x00\x00\x00\x00\x00]\x94(\x8c\x02ok\x94h\x01K\x01K\x02\x86K\x03\x85h\x00"s +
          "0e."s),
      "[u'ok',u'ok',(1,2,),(3,),]");
  EXPECT_EQ(read_as_text("\x80\x05\x96\x03\x00\x00\x00\x00\x00\x00\x00"s + "abc."), "'abc'");
  EXPECT_EQ(read_as_text("\x80\x04\x8f(K\x01\x90."s), "<1,>");
}

TEST(ReadPickle, CallsBecomeRecordsAndAreNeverExecuted) {
  EXPECT_EQ(read_as_text("cos\nsystem\n(S'touch /tmp/never'\ntR."), "!@os system,('touch /tmp/never',),!");
  EXPECT_EQ(read_as_text("(ios\nsystem\n."), "!@os system,(),!");
  EXPECT_EQ(read_as_text("\x80\x04\x8c\x02os\x8c\x06system\x93)\x81}b."s), "!@os system,(),{},!");
  EXPECT_EQ(read_as_text("(cos\nsystem\nI1\no."), "!@os system,(1,),!");
}

TEST(ReadPickle, LongNumbersSaturateAndShortOnesAreExact) {
  EXPECT_EQ(read_as_text("\x80\x02\x8a\x09\xff\xff\xff\xff\xff\xff\xff\xff\x00."s),
            std::to_string(INT64_MAX));
  EXPECT_EQ(read_as_text("\x80\x02\x8a\x09\xff\xff\xff\xff\xff\xff\xff\xff\xff."s), "-1");
  EXPECT_EQ(read_as_text("\x80\x02\x8a\x05\xff\xff\xff\xff\x00."s), "4294967295");
  EXPECT_EQ(read_as_text("L99999999999999999999999L\n."), std::to_string(INT64_MAX));
  EXPECT_EQ(read_as_text("F1e400\n."), "inf");
}

TEST(ReadPickle, FaultsNameTheByte) {
  EXPECT_THAT(pickle_fault(""), HasSubstr("at byte 0"));
  EXPECT_THAT(pickle_fault("."), HasSubstr("at byte 0: the stack is empty"));
  EXPECT_THAT(pickle_fault("N"), HasSubstr("at byte 1"));
  EXPECT_THAT(pickle_fault("NNNt."), HasSubstr("at byte 3: a mark is missing"));
  EXPECT_THAT(pickle_fault("\x80\x06N."s), HasSubstr("protocol 6"));
  EXPECT_THAT(pickle_fault("\x80\x02T\xff\xff\xff\x7f"s + "abc."),
              HasSubstr("at byte 2: 2147483647 bytes are needed and 4"));
  EXPECT_THAT(pickle_fault("\x80\x04\x8e\xff\xff\xff\xff\xff\xff\xff\xff."s), HasSubstr("bytes are needed"));
  EXPECT_THAT(pickle_fault("h\x07."s), HasSubstr("memo 7 was never set"));
  EXPECT_THAT(pickle_fault("Nr\xff\xff\xff\xff."s), HasSubstr("memo 4294967295 is out of range"));
  EXPECT_THAT(pickle_fault("NNa."), HasSubstr("a list is expected"));
  EXPECT_THAT(pickle_fault("}(Nu."), HasSubstr("a key has no value"));
  EXPECT_THAT(pickle_fault("\x97."s), HasSubstr("0x97"));
  EXPECT_THAT(pickle_fault("Ix\n."), HasSubstr("a number is expected"));
  EXPECT_THAT(pickle_fault("I1"), HasSubstr("a line has no end"));
}

TEST(ReadPickle, DeepAndCyclicValuesAreReadAndDropped) {
  std::string deep = "\x80\x02]"s;
  for (int i = 0; i < 200000; ++i) deep += "]a";  // each list empty again: append to the one before
  EXPECT_THAT(read_as_text("\x80\x02]q\x00h\x00"s + "a."), HasSubstr("[[[[["));
  std::string nested = "\x80\x02"s;
  for (int i = 0; i < 200000; ++i) nested += ')';
  for (int i = 0; i < 199999; ++i) nested += '\x86';
  const auto document = read_pickle(bytes_of(nested + "."), "x");
  ASSERT_TRUE(document.ok()) << document.error().what;
  EXPECT_THAT(pickle_fault(std::string(20000, '(') + "."), HasSubstr("nests deeper"));
}

TEST(ReadPickle, ASmallFileTakesLittleMemory) {
  EXPECT_THAT(pickle_fault(std::string(600000, ']') + "."), HasSubstr("more than 500000 values"));
  // A memo index far beyond what was pickled takes nothing.
  EXPECT_THAT(pickle_fault("Np999999999\n."), HasSubstr("out of range"));
}

TEST(FindKey, TakesTheLastOfARepeatedKeyAndOnlyText) {
  const std::string pickle = "\x80\x02}(U\x01"s + "aK\x01K\x05K\x02U\x01" + "aK\x03u.";
  const auto document = read_pickle(bytes_of(pickle), "x");
  ASSERT_TRUE(document.ok());
  const PickleRef* found = find_key(*document, document->root, "a");
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(document->node(*found).integer, 3);
  EXPECT_EQ(find_key(*document, document->root, "b"), nullptr);
  EXPECT_EQ(find_key(*document, *found, "b"), nullptr);
}

}  // namespace
}  // namespace likeness

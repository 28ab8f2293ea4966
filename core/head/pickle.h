// Python pickles read as data: nothing in them is executed. A pickle is a program for a small stack machine
// (Python's pickletools describes protocols 0 to 5); this reader runs only the instructions that build data.
// Instructions that would call Python - GLOBAL, REDUCE, NEWOBJ, BUILD - become inert records of the call; the
// records of numpy, scipy and chumpy are understood by pickle_arrays.h.
//
// All values lie in one flat table and refer to each other by index, so that shared and even cyclic values
// cost nothing and deep nesting cannot overflow the stack. Memory is proportional to the file and bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace likeness {

enum class PickleKind : std::uint8_t {
  none,
  boolean,
  integer,  // beyond 64 bits: saturated
  real,
  text,       // Unicode, UTF-8
  bytes,      // bytes, bytearray, and Python 2's str
  list,       // items: elements
  tuple,      // items: elements
  dict,       // items: key, value, key, value, ...
  set,        // items: elements
  global,     // text: "module name" of a class or function, never looked up
  object,     // items: callable or class, argument tuple, and its state if BUILD gave one
  persistent  // items: the identity by which a pickler stored the value outside the pickle
};

using PickleRef = std::uint32_t;  // index into PickleDocument::nodes

struct PickleNode {
  PickleKind kind = PickleKind::none;
  std::uint32_t offset = 0;  // byte of the instruction that made it
  std::int64_t integer = 0;  // boolean, integer
  double real = 0;
  std::string_view text;  // text, bytes, global; into the file or PickleDocument::decoded
  std::vector<PickleRef> items;
};

struct PickleDocument {
  std::span<const std::byte> file;  // must outlive the document
  std::string name;                 // of the file, for messages
  std::vector<PickleNode> nodes;
  std::deque<std::string> decoded;  // texts that were escaped in the file
  PickleRef root = 0;
  std::size_t end = 0;  // bytes read; another pickle may follow

  const PickleNode& node(PickleRef ref) const { return nodes[ref]; }
};

// Reads the pickle at the start of `file`. An Error names the byte where reading fails.
Result<PickleDocument> read_pickle(std::span<const std::byte> file, const std::string& name);

// The value of a text key in a dict; nullptr if it is missing or `dict` is not a dict.
const PickleRef* find_key(const PickleDocument& document, PickleRef dict, std::string_view key);

// "module name" of the class or function an object is made by; empty for everything else.
std::string_view object_type(const PickleDocument& document, PickleRef ref);

}  // namespace likeness

// Loops that do one thing as fast as the processor can (ceilings_simd.cpp), compiled for several instruction
// sets and chosen at run time. Internal to core/bench. Each returns how many operations it made; `keep`
// receives a value that depends on all of them, so that none is left out.
#pragma once

#include <cstddef>
#include <cstdint>

namespace likeness {

// Floating-point operations of fused multiply-adds on registers.
double fma_block(std::size_t rounds, float& keep);
// The same of dot products of bfloat16 pairs on registers; none without the instruction (bf16_ceiling.cpp).
double bf16_block(std::size_t rounds, float& keep);
// Reads of 8-byte entries (two floats, one entry of the standard field) at random places of a table of
// `entries`, a power of two. The indices are computed on the way, as a hash grid must.
double gather_block(const float* table, std::size_t entries, std::size_t reads, std::uint32_t seed,
                    float& keep);
// The same entries read, added to and written back.
double read_modify_write_block(float* table, std::size_t entries, std::size_t writes, std::uint32_t seed);
// Bytes of `data` read in order; `count` floats.
double stream_block(const float* data, std::size_t count, float& keep);

// Name of the instruction set chosen.
const char* instruction_set();

}  // namespace likeness

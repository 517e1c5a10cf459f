#pragma once

#include <cstdint>
#include <string_view>

namespace vantage {

/// FNV-1a, 64 bits; tells damage and change from what was, not meant against forgery.
/// @param start hash of what came before; the default is that of nothing.
inline uint64_t Fnv1a(std::string_view bytes, uint64_t start = 0xcbf29ce484222325ULL) {
  uint64_t hash = start;
  for (const char byte : bytes) {
    hash = (hash ^ static_cast<unsigned char>(byte)) * 0x100000001b3ULL;
  }
  return hash;
}

/// Spreads every bit over all (finalizer of SplitMix64; Steele, Lea, Flood 2014): inputs that are
/// near each other become unrelated seeds.
inline uint64_t MixBits(uint64_t value) {
  value += 0x9e3779b97f4a7c15ULL;
  value = (value ^ (value >> 30U)) * 0xbf58476d1ce4e5b9ULL;
  value = (value ^ (value >> 27U)) * 0x94d049bb133111ebULL;
  return value ^ (value >> 31U);
}

}  // namespace vantage

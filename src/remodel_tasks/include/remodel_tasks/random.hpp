// A small random generator whose sequence is the same on every machine.
#pragma once

#include <cmath>
#include <cstdint>

namespace remodel {

// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014).
class Random {
 public:
  // Mixed, since seeds apart by a multiple of the step would give the same numbers, shifted.
  explicit Random(std::uint64_t seed) : state_(mix(seed + 1)) {}

  std::uint32_t next() { return static_cast<std::uint32_t>(mix(state_ += kStep) >> 32); }

  // Uniform in 0 .. bound - 1; the bias is below bound / 2^32.
  int below(int bound) {
    return static_cast<int>((static_cast<std::uint64_t>(next()) * bound) >> 32);
  }

  // Uniform in (0, 1].
  double unit() { return (next() + 1.0) / 4294967296.0; }

  // What an annealing step may lose at a temperature: it accepts with probability exp(-loss / T).
  double allowance(double temperature) { return -std::log(unit()) * temperature; }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15ull;

  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return z ^ (z >> 31);
  }

  std::uint64_t state_;
};

}  // namespace remodel

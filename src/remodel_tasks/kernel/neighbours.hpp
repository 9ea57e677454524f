// For each wire, the wires that are cheapest to do right before and right after it.
#pragma once

#include <vector>

#include "arcs.hpp"
#include <remodel_tasks/random.hpp>

namespace remodel {

class Neighbours {
 public:
  // How many of each are kept; 6 to 15 make no difference that could be measured.
  static constexpr int kCount = 10;

  explicit Neighbours(const Arcs& arcs);

  int any_before(int wire, Random& random) const { return before_[pick(wire, random)]; }
  int any_after(int wire, Random& random) const { return after_[pick(wire, random)]; }

 private:
  std::size_t pick(int wire, Random& random) const {
    return static_cast<std::size_t>(wire) * count_ + random.below(count_);
  }

  int count_;
  std::vector<int> before_, after_;
};

}  // namespace remodel

// Costs of doing one wire right after another with the same arm.
#pragma once

#include <vector>

#include "problem.hpp"

namespace remodel {

// For wires i and j, cost(i, j) is what comes between the insertions of i and those of j: the way
// from the slot of i to its first end, from its second end to the slot of j (by way of the tool
// station, with the change, where the tools differ), and the penalties that the pair brings. The
// first end of i is chosen best for each pair, which is exact, since nothing else depends on it.
// Row `wires` is the arm's state at the start, column `wires` the end of the plan.
class Arcs {
 public:
  Arcs(const Problem& problem, int arm);

  int size() const { return size_; }
  int cost(int i, int j) const { return cost_[static_cast<std::size_t>(i) * size_ + j]; }
  const int* row(int i) const { return cost_.data() + static_cast<std::size_t>(i) * size_; }

  // The best first end of wire i when wire j follows (j = wires: none).
  int first_end(int i, int j) const;

  // One arc, without the table: for plans that are patched in less time than the table takes.
  static int follow(const Problem& problem, int arm, int i, int j, int* first);

 private:
  const Problem& p_;
  int arm_, size_;
  std::vector<int> cost_;
};

}  // namespace remodel

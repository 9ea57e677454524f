// Rankings of many wires: every pair picked against its ranks costs the weight.
//
// A soft constraint for each pair would be n^2 / 2 of them. Ranks say the same in n numbers, and the
// pairs that an order violates are counted as inversions, in O(n log n), or between two blocks by
// comparing numbers that lie side by side.
#pragma once

#include <cstdint>
#include <vector>

namespace remodel {

// What a plan costs [tick]: pairs of thousands of wires cost more than 32 bits hold.
using Cost = std::int64_t;

class Ranking {
 public:
  Ranking(const std::int32_t* rank, int wires, int weight);

  Cost weight() const { return weight_; }
  int ranks() const { return ranks_; }
  int of(int wire) const { return rank_[wire]; }   // -1: the order of this wire is of no matter

  // Add to each wire's number what picking it first would cost.
  void add_delays(std::vector<Cost>& delays) const;
  // Take off what the wires that follow no longer cost once a wire is picked.
  void take_off_delays(int picked, std::vector<Cost>& delays) const;

 private:
  Cost weight_;
  int ranks_;
  std::vector<int> rank_;
};

// Counts ranks, and how many of them are greater than another one (Fenwick, 1994).
class RankCounter {
 public:
  explicit RankCounter(int ranks) : sums_(ranks + 1) {}

  void add(int rank) {
    for (std::size_t i = sums_.size() - 1 - rank; i < sums_.size(); i += i & -i) ++sums_[i];
  }
  int above(int rank) const {
    int count = 0;
    for (std::size_t i = sums_.size() - 2 - rank; i > 0; i -= i & -i) count += sums_[i];
    return count;
  }

 private:
  std::vector<int> sums_;   // by rank from the greatest, from 1
};

// How many of `count` ranks at `ranks` are greater than a rank, less those that are smaller.
int balance(const int* ranks, int count, int rank);

}  // namespace remodel

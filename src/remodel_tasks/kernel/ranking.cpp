#include "ranking.hpp"

#include <algorithm>

namespace remodel {

Ranking::Ranking(const std::int32_t* rank, int wires, int weight)
    : weight_(weight), ranks_(0), rank_(rank, rank + wires) {
  for (int r : rank_) ranks_ = std::max(ranks_, r + 1);
}

void Ranking::add_delays(std::vector<Cost>& delays) const {
  std::vector<int> below(ranks_ + 1);
  for (int r : rank_)
    if (r >= 0) ++below[r + 1];
  for (int r = 0; r < ranks_; ++r) below[r + 1] += below[r];
  for (std::size_t wire = 0; wire < rank_.size(); ++wire)
    if (rank_[wire] >= 0) delays[wire] += weight_ * below[rank_[wire]];
}

void Ranking::take_off_delays(int picked, std::vector<Cost>& delays) const {
  const int rank = rank_[picked];
  if (rank < 0) return;
  for (std::size_t wire = 0; wire < rank_.size(); ++wire)
    if (rank_[wire] > rank) delays[wire] -= weight_;
}

int balance(const int* ranks, int count, int rank) {
  int greater = 0, smaller = 0;
  for (int i = 0; i < count; ++i) {
    greater += ranks[i] > rank;
    smaller += (ranks[i] < rank) & (ranks[i] >= 0);
  }
  return greater - smaller;
}

}  // namespace remodel

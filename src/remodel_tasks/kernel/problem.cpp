#include "problem.hpp"

namespace remodel {

Problem::Problem(const WiringTables& tables)
    : t(tables),
      before(t.wires),
      after(t.wires),
      under(t.wires),
      pins{std::vector<std::vector<End>>(t.wires), std::vector<std::vector<End>>(t.wires)},
      soft_before(t.wires),
      soft_after(t.wires),
      ends_at(t.components) {
  for (int i = 0; i < t.unders; ++i) {
    const int* row = t.under + 2 * i;
    under[row[1]].push_back(row[0]);
    before[row[1]].push_back(row[0]);
    after[row[0]].push_back(row[1]);
  }
  for (int i = 0; i < t.pins; ++i) {
    const int* row = t.pin + 4 * i;
    pins[row[3]][row[2]].push_back({row[0], row[1]});
    before[row[2]].push_back(row[0]);
    after[row[0]].push_back(row[2]);
  }
  for (int i = 0; i < t.softs; ++i) {
    const int* row = t.soft + 3 * i;
    soft_before[row[1]].push_back({row[0], row[2]});
    soft_after[row[0]].push_back({row[1], row[2]});
  }
  for (int i = 0; i < t.rankings; ++i)
    rankings.emplace_back(t.rank + static_cast<std::ptrdiff_t>(i) * t.wires, t.wires, t.rank_weight[i]);
  for (int wire = 0; wire < t.wires; ++wire)
    for (int end = 0; end < 2; ++end) ends_at[component(wire, end)].push_back({wire, end});
  if (t.arms > 1) find_shared_ducts();
}

// A bit for each pair of wires with a duct segment in common.
void Problem::find_shared_ducts() {
  words_ = (t.wires + 63) / 64;
  std::vector<std::uint64_t> in_segment(static_cast<std::size_t>(t.segments) * words_);
  for (int wire = 0; wire < t.wires; ++wire)
    for (int i = t.segment_start[wire]; i < t.segment_start[wire + 1]; ++i)
      in_segment[static_cast<std::size_t>(t.segment[i]) * words_ + wire / 64] |= 1ull << (wire % 64);
  shared_.assign(static_cast<std::size_t>(t.wires) * words_, 0);
  for (int wire = 0; wire < t.wires; ++wire) {
    std::uint64_t* row = shared_.data() + static_cast<std::size_t>(wire) * words_;
    for (int i = t.segment_start[wire]; i < t.segment_start[wire + 1]; ++i) {
      const std::uint64_t* other = in_segment.data() + static_cast<std::size_t>(t.segment[i]) * words_;
      for (int word = 0; word < words_; ++word) row[word] |= other[word];
    }
  }
}

}  // namespace remodel

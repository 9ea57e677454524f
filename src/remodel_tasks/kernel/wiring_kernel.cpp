// The kernel's functions for Python, in C's conventions; edge/search_kernel.py declares the same.
#include <memory>

#include "one_arm_search.hpp"
#include "order.hpp"
#include "problem.hpp"
#include "simulation.hpp"
#include "two_arm_search.hpp"

using remodel::Problem;
using remodel::Search;

extern "C" {

Problem* remodel_problem_new(const remodel::WiringTables* tables) { return new Problem(*tables); }

void remodel_problem_delete(Problem* problem) { delete problem; }

// Write the order of wires that follows ranks, and modes; see order.hpp.
void remodel_follow_ranks(const Problem* problem, const std::int32_t* ranks,
                          std::int32_t opening_first, std::int32_t* order, std::int32_t* modes) {
  remodel::follow_ranks(*problem, ranks, opening_first, order, modes);
}

// Simulate a list of wires. Writes up to `capacity` actions, and makespan and penalty. Returns the
// number of actions, or -1 where the arms would wait for each other.
std::int32_t remodel_decode(const Problem* problem, const std::int32_t* order,
                            const std::int32_t* modes, remodel::Action* actions,
                            std::int32_t capacity, std::int64_t* cost) {
  const int n = problem->t.wires;
  remodel::WireList list;
  list.order.assign(order, order + n);
  list.mode.assign(modes, modes + n);
  list.block.resize(n);
  int block = 0;
  for (int i = 0; i < n; ++i) {
    list.block[order[i]] = block;
    block += remodel::Mode::hands_over(modes[order[i]]);
  }
  remodel::Simulator simulator(*problem);
  remodel::Entry entry = simulator.start();
  std::vector<remodel::Action> record;
  record.reserve(capacity);
  cost[0] = cost[1] = 0;
  for (int b = 0, from = 0; b <= block; ++b) {
    int to = from;
    while (to < n && list.block[order[to]] == b) ++to;
    remodel::BlockCost part;
    if (!simulator.run(list, b, from, to, entry, part, &record, static_cast<int>(cost[0])))
      return -1;
    cost[0] += part.duration;
    cost[1] += part.penalty;
    from = to;
  }
  cost[1] += remodel::broken_across_blocks(*problem, list);
  const int count = static_cast<int>(record.size());
  std::copy(record.begin(), record.begin() + std::min(count, capacity), actions);
  return count;
}

Search* remodel_search_new(const Problem* problem, std::uint64_t seed) {
  if (problem->t.arms == 1) return new remodel::OneArmSearch(*problem, seed);
  return new remodel::TwoArmSearch(*problem, seed);
}

void remodel_search_delete(Search* search) { delete search; }

std::int32_t remodel_search_construct(Search* search) { return search->construct(); }

std::int32_t remodel_search_adopt(Search* search, const std::int32_t* order,
                                  const std::int32_t* modes) {
  return search->adopt(order, modes);
}

// Returns the cost of the best plan so far, up to a constant of the problem.
std::int64_t remodel_search_anneal(Search* search, std::int64_t moves, double from, double to) {
  search->anneal(moves, from, to);
  return search->best_cost();
}

void remodel_search_return_to_best(Search* search) { search->return_to_best(); }

std::int64_t remodel_search_best(const Search* search, std::int32_t* order, std::int32_t* modes) {
  search->best(order, modes);
  return search->best_cost();
}

}  // extern "C"

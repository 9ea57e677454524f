// Cable Tree Wiring: the order in which the ends of a harness's cables are inserted.
//
// There are k ends; the first 2 b belong to b two-sided cables, ends i and i + b to cable i. Counted
// from 0 here. problem.py explains what an order must satisfy, problem.py what it costs.
#pragma once

#include <cstdint>
#include <vector>

#include <remodel_tasks/random.hpp>

namespace remodel {

extern "C" {

// Must agree, field by field, with CableTreeTables in cable_tree_planner.py.
struct CableTreeTables {
  std::int32_t ends, cables, atomics, disjunctives, softs, directs;
  const std::int32_t* atomic;        // (atomics, 2) before, after
  const std::int32_t* disjunctive;   // (disjunctives, 4) a before b, or c before d
  const std::int32_t* soft;          // (softs, 2) before, after
  const std::int32_t* direct;        // (directs) ends that the cable's other end follows at once
};

}  // extern "C"

// A set of orders: which end is known to come before which, closed under transitivity.
class Precedence {
 public:
  explicit Precedence(int ends);
  bool before(int a, int b) const { return after_[a * words_ + b / 64] >> (b % 64) & 1; }
  // Add that a comes before b. False if b is known to come before a.
  bool add(int a, int b);
  // Calls visit(b) for each b that a comes before (or after) and `than` is not known to.
  template <class Visit>
  void each_after(int a, int than, Visit visit) const { each(after_, a, than, visit); }
  template <class Visit>
  void each_before(int a, int than, Visit visit) const { each(before_, a, than, visit); }

 private:
  template <class Visit>
  void each(const std::vector<std::uint64_t>& rows, int a, int than, Visit visit) const {
    for (int word = 0; word < words_; ++word)
      for (std::uint64_t bits = rows[a * words_ + word] & ~rows[than * words_ + word]; bits;
           bits &= bits - 1)
        visit(word * 64 + __builtin_ctzll(bits));
  }

  int ends_, words_;
  std::vector<std::uint64_t> after_, before_;
};

class CableTree {
 public:
  explicit CableTree(const CableTreeTables& tables);

  int other_end(int end) const {
    return end >= 2 * t.cables ? -1 : end < t.cables ? end + t.cables : end - t.cables;
  }

  const CableTreeTables t;
  std::vector<char> direct;                       // by end
  std::vector<std::vector<int>> disjunctives_of;  // by end
  std::vector<std::int8_t> soft;                  // (ends, ends) 1: preferred before, -1: after
};

// Put all into `known` that follows from the constraints without trying. False on a contradiction.
bool draw_conclusions(const CableTree& tree, Precedence& known);

// Whether any order satisfies the constraints: kFound writes one, kNone is a proof, kUndecided means
// that `most_nodes` of the search were not enough.
enum class Feasibility { kNone, kFound, kUndecided };
Feasibility find_order(const CableTree& tree, const Precedence& known, std::int64_t most_nodes,
                       int* order);

// Write an order in which cables, taken by chance, have their ends one right after the other as
// far as propagation sees no contradiction. False if the search for it was not enough.
bool gather_cables(const CableTree& tree, Precedence known, std::int64_t most_nodes, Random& random,
                   int* order);

}  // namespace remodel

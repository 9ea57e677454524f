// Annealing on the orders of a cable tree.
//
// An order keeps to all that propagation knows of precedence; disjunctions and direct successors
// may be violated meanwhile, at a price. A move takes one end, or the two neighbouring ends of a
// cable, to another place within the span that precedence leaves. Costs are counted in one pass over
// the order, soft constraints and disjunctions by what the move passes.
#pragma once

#include <cstdint>
#include <vector>

#include "cable_tree.hpp"
#include <remodel_tasks/random.hpp>

namespace remodel {

// What an order is worth; the parts in the order of their importance.
struct OrderCost {
  int broken = 0;    // disjunctions and direct successors
  int stored = 0;    // cables whose ends do not follow each other
  int open = 0;      // most cables hanging open at an insertion
  int longest = 0;   // longest time between the ends of a cable, less one
  int soft = 0;      // violated

  std::int64_t total(int ends) const {
    return ((static_cast<std::int64_t>(stored) * ends + open) * ends + longest) * ends + soft;
  }
};

class CableTreeSearch {
 public:
  // Start from an order that satisfies all constraints.
  CableTreeSearch(const CableTree& tree, const Precedence& known, const int* order,
                  std::uint64_t seed);

  // How much each part weighs while annealing; see problem.py.
  struct Weights {
    double broken, stored, open, longest, soft;
  };
  void anneal(std::int64_t moves, double from, double to, const Weights& weights);
  void return_to_best();
  std::int64_t best_cost() const { return best_cost_; }
  const std::vector<int>& best() const { return best_; }

 private:
  bool propose(int& from, int& count, int& to, bool& reversed);
  void span(int from, int count, int& low, int& high) const;
  bool must_stay_behind(int end, int from, int count) const;
  bool must_stay_before(int end, int from, int count) const;
  void shift(int from, int count, int to);
  void reverse_pair(int at);
  int passed_soft(int from, int count, int to) const;
  void recount_disjunctions(int end);
  void count_order();

  const CableTree& tree_;
  const Precedence known_;
  Random random_;
  int k_;
  std::vector<int> order_, place_, best_;
  std::vector<char> breaks_;   // by disjunction
  int broken_disjunctions_ = 0;
  OrderCost cost_;
  std::int64_t best_cost_ = 0;
};

}  // namespace remodel

// Order of the wires for one arm: sequential ordering with side costs.
//
// With one arm a plan is an order: first ends are chosen per arc (arcs.hpp). What is minimised is
// the sum of the arcs, the violated soft constraints, and the heavy wires picked after a light one.
// The one move exchanges two neighbouring blocks of the order; its cost is found without making it:
// three arcs, the soft constraints and ranks between the blocks, and the place of the first light
// wire. It is allowed if no wire of the left block must be done before one of the right block, which
// direct successors decide.
#pragma once

#include <memory>
#include <vector>

#include "arcs.hpp"
#include "neighbours.hpp"
#include <remodel_tasks/random.hpp>
#include "search.hpp"

namespace remodel {

class OneArmSearch final : public Search {
 public:
  OneArmSearch(const Problem& problem, std::uint64_t seed);

  // Greedy orders from each tool, with and without heavy wires first, with and without regard to
  // the ranks; the cheapest is taken.
  bool construct() override;
  bool adopt(const int* order, const int* modes) override;
  void anneal(std::int64_t moves, double from, double to) override;
  void return_to_best() override;
  void best(int* order, int* modes) const override;
  Cost best_cost() const override { return best_cost_; }

 private:
  struct Exchange {
    int left, middle, right;   // blocks left..middle and middle+1..right change places
  };

  Cost cost_of(const int* order) const;   // without what every order costs
  std::vector<int> greedy(int first_tool, int light_surcharge, bool by_rank) const;
  bool propose(Exchange& move);
  bool allowed(const Exchange& move) const;
  Cost change(const Exchange& move) const;
  Cost change_of_soft_constraints(const Exchange& move) const;
  Cost change_of_rankings(const Exchange& move) const;
  int first_light_after(const Exchange& move) const;
  void make(const Exchange& move);
  void reset(const std::vector<int>& sequence);

  const Problem& p_;
  const Arcs arcs_;
  std::unique_ptr<const Neighbours> neighbours_;
  Random random_;
  int n_, low_;
  // sequence_[0] and sequence_[n + 1] stand for the start and the end of the plan.
  std::vector<int> sequence_, position_, best_;
  std::vector<std::vector<int>> ranked_;   // for each ranking, the ranks along the sequence
  Cost cost_ = 0, best_cost_ = 0;
  int first_light_ = 0;
};

}  // namespace remodel

// A first list for two arms, built in the order in which the arms become free.
#pragma once

#include <vector>

#include "problem.hpp"

namespace remodel {

struct ListPlan {
  std::vector<int> order, modes;
};

// `light_surcharge` is what choosing a light wire costs as long as none has been picked; `by_rank`
// counts what choosing a wire costs before those of smaller rank.
ListPlan greedy_list(const Problem& problem, int light_surcharge, bool by_rank);

}  // namespace remodel

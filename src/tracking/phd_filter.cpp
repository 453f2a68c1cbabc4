// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/phd_filter_impl.h"

namespace kestrel {

template ExpectedObservation<5, 2> expectPosition<5, 2>(const Eigen::Matrix<double, 5, 1>&);
template class PhdFilter<5, 2>;

}  // namespace kestrel

// SPDX-License-Identifier: Apache-2.0
// deprecated: the name before 0.2, for one release.
#pragma once

#include "quench/axis.h"

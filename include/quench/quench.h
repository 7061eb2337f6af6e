// SPDX-License-Identifier: Apache-2.0
/// @file
/// All of the library. Programs that use one stage may include its header alone.
#pragma once

#include "quench/axis.h"
#include "quench/bricks.h"
#include "quench/burn.h"
#include "quench/complex.h"
#include "quench/context.h"
#include "quench/envelope.h"
#include "quench/error.h"
#include "quench/geometry.h"
#include "quench/graph.h"
#include "quench/io.h"
#include "quench/page.h"
#include "quench/parts.h"
#include "quench/pipeline.h"
#include "quench/polygons.h"
#include "quench/preparation.h"
#include "quench/record.h"
#include "quench/samples.h"
#include "quench/shape.h"
#include "quench/simplify.h"
#include "quench/skeleton.h"
#include "quench/table.h"
#include "quench/thickness.h"
#include "quench/solid_stages.h"
#include "quench/tree.h"
#include "quench/verify.h"
#include "quench/voxelize.h"

#define QUENCH_VERSION_MAJOR 0
#define QUENCH_VERSION_MINOR 1
#define QUENCH_VERSION_PATCH 0

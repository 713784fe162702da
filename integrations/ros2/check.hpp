// An assertion that is active in every build, for the tests beside it. SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef TRUEAXIS_CHECK_HPP
#define TRUEAXIS_CHECK_HPP

#include <cstdio>
#include <cstdlib>

#define CHECK(holds)                                                        \
    do {                                                                    \
        if (!(holds)) {                                                     \
            std::printf("FAILED line %d: %s\n", __LINE__, #holds);          \
            std::exit(1);                                                   \
        }                                                                   \
    } while (0)

#endif

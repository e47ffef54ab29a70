/* What numba's machine code calls of numba's own C functions, so that the library needs neither numba
 * nor Python. */

#include <stdint.h>

/* Writes the strides of a reshaped array; returns 0 if the array is not contiguous in C order. */
int numba_attempt_nocopy_reshape(intptr_t dims, const intptr_t *shape, const intptr_t *strides,
                                 intptr_t new_dims, const intptr_t *new_shape,
                                 intptr_t *new_strides, intptr_t item_size, int fortran_order) {
    intptr_t step = item_size;
    if (fortran_order)
        return 0;
    for (intptr_t i = dims - 1; i >= 0; i--) {
        if (shape[i] != 1 && strides[i] != step)
            return 0;
        step *= shape[i];
    }
    step = item_size;
    for (intptr_t i = new_dims - 1; i >= 0; i--) {
        new_strides[i] = step;
        step *= new_shape[i];
    }
    return 1;
}

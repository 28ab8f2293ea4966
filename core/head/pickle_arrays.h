// The arrays inside a pickle: those written by numpy, scipy.sparse, chumpy and torch, rebuilt from the inert
// records of pickle.h. Layouts after numpy's __reduce__ of ndarray, dtype and scalars (also of numpy 2 and of
// protocol 5), scipy's csc_matrix and csr_matrix, chumpy's Ch and its Select and Reshape (the types FLAME's
// and its relatives' files hold), and torch's storages in their older form.
#pragma once

#include "core/base/npz.h"
#include "core/base/result.h"
#include "core/head/pickle.h"

namespace likeness {

// A numeric array, C order. Sparse matrices become dense; numbers and lists of numbers become arrays too. An
// Error says what is there instead. Never takes more memory than a small multiple of the file.
Result<NpyArray> pickle_array(const PickleDocument& document, PickleRef ref);

// The elements of a numpy array of objects, or of a list or tuple; an Error for anything else.
Result<std::vector<PickleRef>> pickle_elements(const PickleDocument& document, PickleRef ref);

}  // namespace likeness

//! Reading OBJ.

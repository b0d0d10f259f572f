//! Loops compiled for the vector units that the CPU has.

/// Declares a function whose body is compiled a second time for AVX2, taken where the CPU has it.
macro_rules! kernel {
    ($(#[$meta:meta])* $visible:vis fn $name:ident($($argument:ident: $type:ty),* $(,)?) -> $result:ty $body:block) => {
        $(#[$meta])*
        #[allow(clippy::too_many_arguments, reason = "a kernel takes what its loop reads")]
        $visible fn $name($($argument: $type),*) -> $result {
            #[inline(always)]
            #[allow(clippy::too_many_arguments, reason = "as above")]
            fn generic($($argument: $type),*) -> $result $body
            #[cfg(target_arch = "x86_64")]
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                #[target_feature(enable = "avx2,fma")]
                #[allow(clippy::too_many_arguments, reason = "as above")]
                fn avx2($($argument: $type),*) -> $result {
                    generic($($argument),*)
                }
                // SAFETY: the CPU has what the function is compiled for.
                return unsafe { avx2($($argument),*) };
            }
            generic($($argument),*)
        }
    };
}

pub(crate) use kernel;

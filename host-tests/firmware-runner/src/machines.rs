//! The machines that images are built for and run on.

use std::process::Command;

/// A machine of QEMU's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// QEMU's name.
    pub name: &'static str,
    /// Its processor.
    pub core: &'static str,
    /// QEMU's program.
    pub qemu: &'static str,
    /// The compiler's target.
    pub target: &'static str,
    /// The compiler's name of the processor, where the target does not say it all.
    pub cpu: Option<&'static str>,
    /// The C compiler,
    pub gcc: &'static str,
    /// and what it calls the processor.
    pub gcc_flags: &'static [&'static str],
    /// Whether f32 is the machine's own.
    pub hard_float: bool,
}

/// All machines.
pub const MACHINES: [Machine; 5] = [
    Machine {
        name: "mps2-an385",
        core: "Cortex-M3",
        qemu: "qemu-system-arm",
        target: "thumbv7m-none-eabi",
        cpu: None,
        gcc: "arm-none-eabi-gcc",
        gcc_flags: &["-mcpu=cortex-m3", "-mthumb"],
        hard_float: false,
    },
    Machine {
        name: "mps2-an386",
        core: "Cortex-M4",
        qemu: "qemu-system-arm",
        target: "thumbv7em-none-eabihf",
        cpu: Some("cortex-m4"),
        gcc: "arm-none-eabi-gcc",
        gcc_flags: &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard"],
        hard_float: true,
    },
    Machine {
        name: "mps2-an500",
        core: "Cortex-M7",
        qemu: "qemu-system-arm",
        target: "thumbv7em-none-eabihf",
        cpu: Some("cortex-m7"),
        gcc: "arm-none-eabi-gcc",
        gcc_flags: &["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard"],
        hard_float: true,
    },
    Machine {
        name: "mps2-an505",
        core: "Cortex-M33",
        qemu: "qemu-system-arm",
        target: "thumbv8m.main-none-eabihf",
        cpu: Some("cortex-m33"),
        gcc: "arm-none-eabi-gcc",
        gcc_flags: &["-mcpu=cortex-m33", "-mthumb", "-mfloat-abi=hard"],
        hard_float: true,
    },
    Machine {
        name: "virt",
        core: "RV32IMAC",
        qemu: "qemu-system-riscv32",
        target: "riscv32imac-unknown-none-elf",
        cpu: None,
        gcc: "riscv64-unknown-elf-gcc",
        gcc_flags: &["-march=rv32imac_zicsr", "-mabi=ilp32"],
        hard_float: false,
    },
];

/// Targets that the library must build for although no machine here runs them.
pub const BUILT_ONLY: [&str; 2] = ["thumbv6m-none-eabi", "thumbv8m.main-none-eabi"];

impl Machine {
    /// The machine of a name, QEMU's or the processor's.
    pub fn find(name: &str) -> Option<Self> {
        let same = |m: &&Self| m.name.eq_ignore_ascii_case(name) || m.core.eq_ignore_ascii_case(name);
        MACHINES.iter().find(same).copied()
    }

    /// Whether it is an Arm.
    pub fn is_arm(&self) -> bool {
        self.qemu == "qemu-system-arm"
    }

    /// The command that runs a program. With `counted`, time stands for instructions, exactly.
    pub fn command(&self, program: &std::path::Path, counted: bool) -> Command {
        let mut command = Command::new(self.qemu);
        command.args(["-M", self.name]);
        if self.is_arm() {
            command.args(["-serial", "none"]);
        } else {
            command.args(["-m", "64M", "-bios", "none", "-serial", "none"]);
        }
        command.args(["-display", "none", "-monitor", "none"]);
        command.args(["-semihosting-config", "enable=on,target=native"]);
        if counted {
            command.args(["-icount", "shift=0"]);
        }
        command.arg("-kernel").arg(program);
        command
    }
}
